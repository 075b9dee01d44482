#!/usr/bin/env python3
"""Writes the man page of a tool: man_page.py TOOL NOTES ARTIFACTS VERSION DATE >TOOL.1

Options and commands come from the tool's --help, the exit codes from docs/artifacts.md (ARTIFACTS), and what else a reader needs from
NOTES, a file of paragraphs: "## TITLE" begins a section, lines that are set in by four are shown as they are, and `this` is bold.
"""
import re
import sys
import textwrap

from tool_help import read_tool

TOOLS = ("pm-scene pm-ground pm-lift pm-material pm-candidates pm-simulate pm-render pm-screen pm-report pm-eval").split()


def wrapped(text):
    """Source lines of at most 80 characters; one that would begin with a control character gets an empty character in front."""
    lines = textwrap.wrap(text, 78, break_long_words=False, break_on_hyphens=False)
    return ["\\&" + l if l[0] in ".'" else l for l in lines]


def plain(text):
    text = text.replace("\\", "\\e").replace("-", "\\-").replace("'", "\\(aq").replace("`", "\\(ga")
    return "".join(c if ord(c) < 128 else f"\\[u{ord(c):04X}]" for c in text)


def marked(text):
    """Text in which `this` is bold."""
    return "".join(f"\\fB{plain(p)}\\fR" if i % 2 else plain(p) for i, p in enumerate(text.split("`")))


def sentence(text):
    return (text[0].upper() + text[1:] if re.match(r"[a-z]+\b(?![./=:_])", text) else text) + ("" if text.endswith((".", ":")) else ".")


def shown(lines):
    """Lines as they are, set in."""
    return [".PP", ".in +4n", ".nf", *(plain(l) or ".sp" for l in lines), ".fi", ".in"]


def paragraphs(text):
    out = []
    for block in re.split(r"\n\s*\n", text.strip("\n")):
        lines = block.split("\n")
        if all(l.startswith("    ") for l in lines):
            out += shown(l[4:] for l in lines)
        else:
            out += [".PP", *wrapped(marked(" ".join(l.strip() for l in lines)))]
    return out


def section(title, body, macro="SH"):
    """A heading takes the place of the first paragraph's macro."""
    if not body:
        return []
    return [f'.{macro} "{plain(title)}"' if " " in title else f".{macro} {plain(title)}", *(body[1:] if body[0] == ".PP" else body)]


def value_of(option):
    """As it is written behind the option's name: choices and fixed words bold, the rest italic."""
    if option.choices:
        return "|".join(f"\\fB{plain(c)}\\fR" for c in option.choices)
    return "|".join(f"\\fI{plain(v)}\\fR" for v in option.value.split("|")).replace("... ...", "...") if option.value else ""


def option_item(option):
    names = [f"\\fI{plain(n)}\\fR" if option.positional else f"\\fB{plain(n)}\\fR" for n in option.names]
    head = ", ".join(names)
    if option.value and not option.positional:
        head += " " + value_of(option)
    text = sentence(option.text)
    if option.required and not option.positional:
        text += " Required."
    if option.bounds:
        low, high = option.bounds.split(" - ")
        text += f" From {low} to {high}."
    if option.default:
        text += f" Default: {option.default}."
    for word, others in (("Needs", option.needs), ("Not together with", option.excludes)):
        text += f" {word} {', '.join(others)}." if others else ""
    return [".TP", head, *wrapped(plain(text))]


def group_items(group):
    out = [".PP", *wrapped(plain(sentence(group.text)))] if group.text else []
    for option in group.options:
        out += option_item(option)
    return out


def synopsis(command):
    """The name, what must be given, and how the rest is called."""
    words = [f"\\fB{plain(command.name)}\\fR"]
    for option in command.options():
        if option.required and not option.positional:
            words.append(f"\\fB{plain(option.names[0])}\\fR {value_of(option)}")
    usage = command.usage.replace(command.name, "", 1).replace("[OPTIONS]", "[OPTION]...").split()
    # All that is left of the usage: [OPTION]... and positional arguments.
    words += [re.sub(r"[A-Z]+", lambda m: f"\\fI{m.group(0)}\\fR", plain(w)) for w in usage]
    return " ".join(words)


def split_footer(lines):
    """Examples, each a list of lines no wider than a terminal, and remarks."""
    examples, remarks = [], []
    for line in lines:
        match = re.match(r"(?:(Examples?|[A-Z][\w ]*):)?\s*(pm-[a-z]+ .*)$", line)
        if match:
            label, text = match.groups()
            rows = [] if label in (None, "Example", "Examples") else [f"# {label}"]
            row = ""
            for word in re.split(r" (?=--)", text):
                if row and len(row) + len(word) > 68:
                    rows.append(row + " \\")
                    row = "    " + word
                else:
                    row = f"{row} {word}" if row else word
            examples.append(rows + [row])
        elif line.strip() and remarks and re.match(r"\s*[a-z]", line):
            remarks[-1] += " " + line.strip()
        elif line.strip():
            remarks.append(re.sub(r"\s+", " ", line.strip()))
    return examples, remarks


def exit_codes(artifacts):
    text = open(artifacts, encoding="utf-8").read()
    match = re.search(r"^## Exit codes\n(.*?)(?=^## |\Z)", text, re.S | re.M)
    rows = re.findall(r"^\| (\d+) \| (.*?) \|$", match.group(1), re.M) if match else []
    if not rows:
        raise SystemExit(f"{artifacts}: no table below \"## Exit codes\"")
    return [line for code, meaning in rows for line in (".TP", f"\\fB{code}\\fR", *wrapped(marked(sentence(meaning))))]


def page(tool, notes, artifacts, version, date):
    command = read_tool(tool)
    examples, remarks = split_footer(command.footer)
    environment = [r for r in remarks if "environment variable" in r]
    sections = re.split(r"^## (.*)\n", open(notes, encoding="utf-8").read(), flags=re.M)
    about = command.text.rstrip(".")
    about = about if re.match(r"[A-Z][A-Z]", about) else about[0].lower() + about[1:]
    out = [f'.TH {command.name.upper()} 1 "{date}" "PhysMAS {version}" "PhysMAS"', ".nh"]
    out += [".SH NAME", *wrapped(f"{plain(command.name)} \\- {plain(about)}")]
    # A command of its own per line; ragged, since long names do not fill lines.
    alone = "SUBCOMMAND" not in command.usage or "[SUBCOMMAND]" in command.usage
    lines = [wrapped(synopsis(c)) for c in ([command] if alone else []) + command.commands]
    out += [".SH SYNOPSIS", ".ad l", *lines[0], *(l for line in lines[1:] for l in (".br", *line)), ".ad b"]
    body = paragraphs(sections[0])
    for remark in remarks:
        if remark not in environment:
            body += [".PP", *wrapped(plain(remark))]
    out += section("DESCRIPTION", body)
    body = []
    for sub in command.commands:
        body += section(sub.name.split()[1], [".PP", *wrapped(plain(sentence(sub.text)))], "SS")
        for group in sub.groups:
            group.options = [o for o in group.options if "--help" not in o.names]
            body += ([] if group.title in ("Positionals", "Options") else [".PP", plain(group.title + ":")]) + group_items(group)
    out += section("COMMANDS", body)
    # The options that all tools share come last.
    groups = sorted(command.groups, key=lambda g: g.title == "Common")
    out += section("OPTIONS", group_items(groups[0]))
    for group in groups[1:]:
        out += section("Common options" if group.title == "Common" else group.title.capitalize(), group_items(group), "SS")
    for title, text in zip(sections[1::2], sections[2::2]):
        out += section(title, paragraphs(text))
    out += section("ENVIRONMENT", [l for r in environment for l in (".PP", *wrapped(plain(r)))])
    out += section("EXIT STATUS", exit_codes(artifacts))
    out += section("EXAMPLES", [l for example in examples for l in shown(example)])
    others = ", ".join(f"\\fB{plain(t)}\\fR(1)" for t in TOOLS if t != command.name)
    out += section("SEE ALSO", [*wrapped(others), ".PP", *wrapped(plain("Documentation, records and formats: share/doc/physmas below the prefix."))])
    return "\n".join(out) + "\n"


if __name__ == "__main__":
    if len(sys.argv) != 6:
        sys.exit(__doc__)
    sys.stdout.write(page(*sys.argv[1:]))
