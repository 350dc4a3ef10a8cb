"""The option tables of docs/cli.md hold exactly the options of --help, with the same defaults.

    cli_help_test.py PROGRAM DOCS_FOLDER
"""
import pathlib
import re
import subprocess
import sys
import unittest

PROGRAM, DOCS = sys.argv[1], pathlib.Path(sys.argv[2])
del sys.argv[1:3]

NAME = r"(?:--?[a-z][a-z-]*|[A-Z]+)"


def help_of(*command):
    return subprocess.run([PROGRAM, *command, "--help"], capture_output=True, text=True).stdout


def commands():
    """The subcommands listed by --help."""
    listed = help_of().split("Subcommands:")[1]
    return re.findall(r"^  ([a-z]+) ", listed, re.MULTILINE)


def options_of_help(command):
    """Option -> default (empty: none), from the lines that begin with an option."""
    options = {}
    text = help_of(command).split("Positionals:")[1]
    # A long option stands on a line of its own, and its description on the next.
    text = re.sub(r"\n {20,}", "  ", text)
    for line in text.splitlines():
        found = re.match(rf"  ({NAME})(?:,--help)?(?= |$)(.*)", line)
        if not found or found[1] == "-h":
            continue
        syntax = re.split(r" {2,}", found[2].strip())[0]
        default = re.search(r"\[([^\]]*)\]$|=(\S+)", re.sub(r" (REQUIRED|\.\.\.)", "", syntax))
        options[found[1]] = (default[1] or default[2]) if default else ""
    return options


def options_of_page(command):
    """The same from the first table of the command's section."""
    page = (DOCS / "cli.md").read_text(encoding="utf-8")
    section = re.search(rf"^## {command}\n(.*?)(?=^## |\Z)", page, re.MULTILINE | re.DOTALL)[1]
    table = section.split("| option | default | meaning |")[1].split("\n\n")[0]
    options = {}
    for row in table.splitlines()[2:]:
        name, default = re.match(rf"\| `({NAME})[^`]*` \|(.*?)\|", row).groups()
        options[name] = default.strip().strip("`")
    return options


class Help(unittest.TestCase):
    def test_every_command_has_a_section(self):
        page = (DOCS / "cli.md").read_text(encoding="utf-8")
        self.assertEqual(sorted(commands()), sorted(re.findall(r"^## ([a-z]+)$", page, re.M)))

    def test_options_and_defaults_agree(self):
        for command in commands():
            with self.subTest(command):
                self.assertEqual(options_of_help(command), options_of_page(command))

    def test_help_fits_plain_text(self):
        for command in commands():
            self.assertTrue(help_of(command).isascii(), command)


if __name__ == "__main__":
    unittest.main()
