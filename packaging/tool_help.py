"""What a tool's --help says, as data: for the man pages and the shell completion."""
import re
import subprocess
from dataclasses import dataclass, field


@dataclass
class Option:
    names: list  # ["-h", "--help"]; of a positional argument its name
    value: str = ""  # what it takes, as --help names it: "FILE", "FLOAT x 6"; empty for a flag
    choices: list = field(default_factory=list)  # all values that are allowed
    bounds: str = ""  # "0 - 1024"
    default: str = ""
    required: bool = False
    needs: list = field(default_factory=list)
    excludes: list = field(default_factory=list)
    text: str = ""

    @property
    def positional(self):
        return not self.names[0].startswith("-")


@dataclass
class Group:
    title: str  # "Options", "Common"
    text: str = ""
    options: list = field(default_factory=list)


@dataclass
class Command:
    name: str  # "pm-scene import"
    text: str = ""
    usage: str = ""
    groups: list = field(default_factory=list)
    commands: list = field(default_factory=list)  # subcommands
    footer: list = field(default_factory=list)  # lines

    def options(self):
        return [o for g in self.groups for o in g.options]


def read_option(head, text):
    words = head.split()
    names = words[0].split(",")
    option = Option(names, text=text)
    rest = " ".join(words[1:])
    for word, key in (("Excludes", "excludes"), ("Needs", "needs")):
        match = re.search(rf"(?:^| ){word}:((?: --[\w-]+)+)$", rest)
        if match:
            setattr(option, key, sorted(match.group(1).split()))
            rest = rest[: match.start()]
    if rest.endswith("REQUIRED"):
        option.required, rest = True, rest[: -len("REQUIRED")].rstrip()
    match = re.match(r"([^\s:={|]+)(?::\{([^}]*)\}|:\w+ in \[([^\]]*)\]|:[A-Z]+)?(?:=(\S+))?((?: x \d+| \.\.\.)?)$", rest)
    if match:
        kind, choices, bounds, default, count = match.groups()
        option.value = kind + count
        option.choices = choices.split(",") if choices else []
        option.bounds = bounds or ""
        option.default = default or ""
    elif "|" in rest:  # a type of its own, as builtin|URL|replay:DIR=builtin
        option.value, _, option.default = rest.partition("=")
    elif rest:
        raise SystemExit(f"{names[0]}: no rule reads \"{rest}\"")
    return option


def read_command(name, help_text):
    lines = help_text.rstrip().split("\n")
    # The column at which texts begin; a longer name puts its text into the next line.
    column = next(l for l in lines if "--help" in l).index("Print this help")
    command = Command(name)
    at = next(i for i, l in enumerate(lines) if l.startswith("Usage: "))
    command.text = " ".join(lines[:at])
    command.usage = lines[at][len("Usage: "):]
    group, subcommands, inner = None, [], 0  # inner: how far an option group is set in
    lines = lines[at + 1:]
    while lines:
        line = lines.pop(0)
        match = re.match(r"\[Option Group: (.*)\]$", line)
        if match:
            group, inner = Group(match.group(1)), 2
            command.groups.append(group)
        elif re.match(r"[A-Z][\w ]*:$", line) and lines and lines[0].startswith("  "):
            group, inner = (None if line == "Subcommands:" else Group(line[:-1])), 0
            if group:
                command.groups.append(group)
        elif inner and line.strip() == "Options:":
            pass
        elif inner and re.match(r"  \S", line) and not line.strip().startswith("-"):
            group.text += (". " if group.text else "") + line.strip().strip("[]")
        elif line.startswith(" " * (2 + inner)) and line.strip() and not command.footer:
            line = line[inner:]
            if lines and lines[0].startswith(" " * (column + inner)):
                head, text = line.strip(), lines.pop(0).strip()
            else:
                head, text = line[:column].strip(), line[column:].strip()
            if group:
                group.options.append(read_option(head, text))
            else:
                subcommands.append((head, text))
        elif line.strip():
            # All that follows is the footer.
            command.footer = [line] + lines
            break
        elif not line.strip():
            inner = 0
    return command, subcommands


def run(tool, *arguments):
    return subprocess.run([tool, *arguments], check=True, capture_output=True, text=True).stdout


def read_tool(path):
    """The command line of the program at `path`, its subcommands included."""
    name = path.split("/")[-1]
    command, subcommands = read_command(name, run(path, "--help"))
    for sub, _ in subcommands:
        read, _ = read_command(f"{name} {sub}", run(path, sub, "--help"))
        command.commands.append(read)
    return command
