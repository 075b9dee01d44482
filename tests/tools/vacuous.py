#!/usr/bin/env python3
"""vacuous.py FILE...: the lines of bats tests whose failure nobody notices, as FILE:LINE: WHY; exit code 1 if there are any.

A test fails where a command fails, but bash excuses these, wherever they are not a test's last command:
- `! command`: refute of common.bash is the way to say no;
- what stands before a `&&`: two commands are two lines. Conditions, and lists that end in break, continue, return or skip, are
  another matter;
- an assertion before `|| true`, or before a pipe;
- a search that ends in a filter which only prints, as in `grep x file | wc -l`;
- `run command` whose status, output and error nothing looks at before the next `run` or the end of the test.
"""
import re
import sys

ASSERTIONS = {"[", "[[", "test", "grep", "cmp", "diff", "refute", "fails_with"}
FILTERS = {"awk", "cat", "cut", "head", "sed", "sort", "tail", "tee", "tr", "uniq", "wc"}
CONDITIONS = {"if", "elif", "while", "until"}
CONTROL = {"break", "continue", "return", "skip", "exit"}


def without_text(source):
    """The source with the same length and lines, in which quoted text, substitutions, [[ ]], comments and here-documents are x."""
    out = list(source)
    bodies = []  # delimiters of the here-documents that start on this line

    def blank(start, end):
        for k in range(start, min(end, len(source))):
            if out[k] != "\n":
                out[k] = "x"

    def quoted(i):  # the end of the quoted text, substitution or group that starts at i
        if source[i] == "'":
            return source.index("'", i + 1) + 1
        if source[i] == '"':
            i += 1
            while source[i] != '"':
                i = i + 2 if source[i] == "\\" else quoted(i) if source.startswith("$(", i) else i + 1
            return i + 1
        i = source.index("(", i) + 1  # $( or <(
        while source[i] != ")":
            i = i + 2 if source[i] == "\\" else quoted(i) if source[i] in "'\"(" else i + 1
        return i + 1

    i = 0
    while i < len(source):
        word_starts = i == 0 or source[i - 1] in " \t\n;(|&"
        here = re.compile(r"<<-?\s*(['\"]?)(\w+)\1").match(source, i) if not source.startswith("<<<", i) else None
        if source.startswith("\\\n", i):
            out[i] = out[i + 1] = " "
            i += 2
        elif source[i] == "\\":
            i += 2
        elif source.startswith("<<<", i):
            i += 3
        elif here:
            bodies.append(here[2])
            i = here.end()
        elif source[i] == "\n" and bodies:
            i += 1
            for delimiter in bodies:
                end = re.compile(rf"^\s*{delimiter}$", re.M).search(source, i).end()
                blank(i, end)
                i = end
            bodies = []
        elif source[i] == "#" and word_starts:
            end = (source + "\n").index("\n", i)
            blank(i, end)
            for k in range(i, end):
                out[k] = " "
            i = end
        elif source.startswith("[[ ", i) and word_starts:
            end = source.index(" ]]", i)
            blank(i + 3, end)
            i = end + 3
        elif source.startswith("${", i):
            end = source.index("}", i) + 1
            blank(i, end)
            i = end
        elif source[i] in "'\"" or source.startswith(("$(", "<(", ">("), i):
            end = quoted(i)
            blank(i, end)
            i = end
        else:
            i += 1
    return "".join(out)


def statements(source):
    """(offset, text, original text) of the commands and lists between separators."""
    text = without_text(source)
    separator = re.compile(r"\n|;|(?<![&>])&(?![&>])|(?:(?<=\s)|^)(?:then|do|else|\{|\}|\(|\))(?=\s|;|$)|(?<=[\s;])\((?=\S)|\)(?=\s*(?:\n|$))", re.M)
    start = 0
    for match in [*separator.finditer(text), None]:
        end = match.start() if match else len(text)
        if text[start:end].strip():
            start += len(text[start:end]) - len(text[start:end].lstrip())
            yield start, text[start:end].rstrip(), source[start:end]
        start = match.end() if match else end


def first_word(command):
    words = command.split()
    while words and re.match(r"\w+=", words[0]):
        words = words[1:]
    return words[0] if words else ""


def faults(source):
    """(line, why) of every command whose failure is lost."""
    pending = None  # offset of a `run` that nothing has looked at yet
    found = []
    for offset, text, original in statements(source):
        tokens = re.split(r"(&&|\|\||\|&?)", text)
        commands, operators = [c.strip() for c in tokens[::2]], tokens[1::2]
        words = [first_word(c) for c in commands]
        if words[0] in ("@test", "setup()", "teardown()", "run"):
            if pending is not None:
                found.append((pending, "nothing looks at what this run gives"))
            pending = offset if words[0] == "run" and not re.match(r"run\s+(--\S+\s+)*(!|-\d)", text) else None
            if words[0] != "run":
                continue
        elif re.search(r"\$\{?(status|output|lines|stderr|stderr_lines)\b", original):
            pending = None
        if words[0] in CONDITIONS:
            continue
        if "!" in words:
            found.append((offset, "bats ignores the failure of a negated command: use refute"))
            continue
        last_or = max([k for k, o in enumerate(operators) if o == "||"], default=-1)
        if "&&" in operators[last_or + 1:] and words[-1] not in CONTROL:
            found.append((offset, "the failure of what stands before && is ignored: use two commands"))
        if last_or >= 0 and words[-1] in ("true", ":") and words[last_or] in ASSERTIONS:
            found.append((offset, "|| true takes this assertion's failure"))
        for k, operator in enumerate(operators):
            if operator[0] == "|" and operator != "||" and (
                    words[k] in ASSERTIONS - {"grep"} or
                    words[k] == "grep" and words[k + 1] in FILTERS and ">" not in commands[k + 1]):
                found.append((offset, "the status of what stands before the pipe is lost"))
    if pending is not None:
        found.append((pending, "nothing looks at what this run gives"))
    return sorted((source.count("\n", 0, offset) + 1, why) for offset, why in found)


if __name__ == "__main__":
    count = 0
    for path in sys.argv[1:]:
        for line, why in faults(open(path).read()):
            print(f"{path}:{line}: {why}")
            count += 1
    sys.exit(1 if count else 0)
