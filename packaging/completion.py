#!/usr/bin/env python3
"""Writes the bash completion of a tool from its --help: completion.py TOOL >TOOL

Options, commands, and what an option takes: its values where --help lists them, folders, files, or nothing that can be guessed.
"""
import sys

from tool_help import read_tool

TEMPLATE = """\
# bash completion of {tool}, made from its --help.
_{function}() {{
  local current=${{COMP_WORDS[COMP_CWORD]}} previous=${{COMP_WORDS[COMP_CWORD-1]}} command= take=files words= word
  # Readline takes "--up=-y" for three words.
  if [ "$current" = = ]; then
    current=
  elif [ "$previous" = = ]; then
    previous=${{COMP_WORDS[COMP_CWORD-2]}}
  fi
  for word in "${{COMP_WORDS[@]:1:COMP_CWORD-1}}"; do
    case $word in {commands}) command=$word; break ;; esac
  done
  case "$command $previous" in
{values}
    *)
      if [[ $current = -* ]]; then
        take=words
        case $command in
{options}
        esac
      elif [ -z "$command" ]; then
        {bare}
      fi
      ;;
  esac
  COMPREPLY=()
  case $take in
    words) mapfile -t COMPREPLY < <(compgen -W "$words" -- "$current") ;;
    folders) mapfile -t COMPREPLY < <(compgen -d -- "$current") ;;
    files) mapfile -t COMPREPLY < <(compgen -f -- "$current") ;;
  esac
  # Outside of readline compopt has nothing to change.
  case $take in files|folders) compopt -o filenames 2>/dev/null ;; esac
  case ${{COMPREPLY-}} in *:) compopt -o nospace 2>/dev/null ;; esac
  return 0
}}
complete -F _{function} {tool}
"""


def taken(option):
    """What completes an option's value: `take=` files, folders, words or nothing."""
    kind = option.value.split()[0].rstrip(".")
    words = option.choices
    if "|" in kind:
        # The fixed words of builtin|URL|replay:DIR, and what stands before a colon.
        words = [w[: w.find(":") + 1] or w for w in kind.split("|") if not w.isupper()]
    if words:
        return f"take=words words='{' '.join(words)}'"
    return {"DIR": "take=folders", "INT": "take=", "FLOAT": "take=", "NAME": "take="}.get(kind, "take=files")


def completion(path):
    tool = read_tool(path)
    names = [c.name.split()[1] for c in tool.commands]
    own, shared, options = {}, {}, []  # patterns of "COMMAND OPTION" by what is taken
    for command in [*tool.commands, tool]:
        prefix = "*" if command is tool else command.name.split()[1]
        flags = [o for o in command.options() if not o.positional]
        # The tool's own options are understood behind a command, too.
        words = dict.fromkeys(n for o in flags + ([] if command is tool else tool.options()) for n in o.names)
        options.append(f"          {prefix}) words='{' '.join(words)}' ;;")
        for option in flags:
            if option.value:
                group = shared if command is tool else own
                group.setdefault(taken(option), []).append(f"{prefix}\\ {option.names[-1]}")
    values = [f"    {'|'.join(patterns)}) {take} ;;" for group in (own, shared) for take, patterns in group.items()]
    return TEMPLATE.format(tool=tool.name, function=tool.name.replace("-", "_"), commands="|".join(names) or "''",
                           values="\n".join(values), options="\n".join(options),
                           bare=f"take=words words='{' '.join(names)}'" if names else "take=files")


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    sys.stdout.write(completion(sys.argv[1]))
