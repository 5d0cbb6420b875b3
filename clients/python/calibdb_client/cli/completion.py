"""The command `completion`."""

import argparse
from collections.abc import Iterator
from typing import Any

from . import options
from .output import Output

SHELLS = ("bash", "zsh", "fish")
_BASH = """_calibdb() {{
  local word="${{COMP_WORDS[COMP_CWORD]}}" words
  if [ "$COMP_CWORD" -eq 1 ]; then words="{commands}"; else
    case "${{COMP_WORDS[1]}}" in
{cases}
    esac
  fi
  case "$word" in
    -*) COMPREPLY=($(compgen -W "$words" -- "$word")) ;;
    *) [ "$COMP_CWORD" -eq 1 ] && COMPREPLY=($(compgen -W "$words" -- "$word")) || COMPREPLY=() ;;
  esac
}}
complete -o default -F _calibdb calibdb
"""


def add(commands: Any) -> None:
    """Add the command to the parser."""
    parser = options.add_command(
        commands,
        "completion",
        run,
        "print a script that completes commands and options in a shell",
        "Print a script that completes commands and options. bash, in ~/.bashrc: "
        'eval "$(calibdb completion bash)". zsh, in ~/.zshrc after compinit: the same with zsh. '
        "fish: calibdb completion fish > ~/.config/fish/completions/calibdb.fish",
    )
    parser.add_argument("shell", choices=SHELLS)


def run(chosen: argparse.Namespace, _: Output) -> int:
    """Print the script."""
    from .program import parser

    print(script(chosen.shell, parser()), end="")
    return 0


def script(shell: str, program: argparse.ArgumentParser) -> str:
    """Return the script of a shell for the commands and options of a program."""
    commands = commands_of(program)
    if shell == "fish":
        return "\n".join(_fish(program)) + "\n"
    cases = "\n".join(
        f'      {name}) words="{" ".join(options_of(parser))}" ;;' for name, parser in commands.items()
    )
    bash = _BASH.format(commands=" ".join(commands), cases=cases)
    return f"autoload -U +X bashcompinit && bashcompinit\n{bash}" if shell == "zsh" else bash


def _fish(program: argparse.ArgumentParser) -> Iterator[str]:
    helps = {each.dest: each.help or "" for each in _subparsers(program)._choices_actions}
    for name, parser in commands_of(program).items():
        yield f"complete -c calibdb -n __fish_use_subcommand -f -a {name} -d {_quoted(helps[name])}"
        for action in _options(parser):
            flags = " ".join(
                f"-l {flag[2:]}" if flag.startswith("--") else f"-s {flag[1:]}"
                for flag in action.option_strings
            )
            values = f" -x -a {_quoted(' '.join(map(str, action.choices)))}" if action.choices else ""
            about = f"{flags}{values} -d {_quoted(action.help or '')}"
            yield f"complete -c calibdb -n '__fish_seen_subcommand_from {name}' {about}"


def options_of(parser: argparse.ArgumentParser) -> list[str]:
    """Return the options of a command."""
    return [flag for action in _options(parser) for flag in action.option_strings]


def commands_of(program: argparse.ArgumentParser) -> dict[str, argparse.ArgumentParser]:
    """Return the parser of every command, by its name."""
    return dict(_subparsers(program).choices)


def _subparsers(program: argparse.ArgumentParser) -> Any:
    return next(each for each in program._actions if isinstance(each, argparse._SubParsersAction))


def _options(parser: argparse.ArgumentParser) -> list[argparse.Action]:
    return [each for each in parser._actions if each.option_strings]


def _quoted(text: str) -> str:
    return "'" + text.replace("\\", "\\\\").replace("'", "\\'").replace("%%", "%") + "'"
