"""The commands that people are told to run: found in the strings of the sources, the manual pages and the documents, and completed by what
the programs' own --help says of each option and argument."""
import difflib
import re
import shlex
import subprocess

PROGRAMS = ("hapticd-model", "hapticd-lab", "hapticd-oracle", "hapticd-play", "haptic-web", "haptic-audio", "haptic-osc", "haptic-relay", "hapticctl",
            "hapticd")
NAMED = re.compile(rf"(?<![\w./-])({'|'.join(PROGRAMS)})(?=[ '\"`]|$)")
IN_BUILD = re.compile(r"(?<!\S)build/\w+/bin/(?=haptic)")
PLACE = "\N{REPLACEMENT CHARACTER}"  # stands for what a program fills in
TOLERATED = 0.75  # a word as close to a command as this is meant to be one


# --- Texts ---------------------------------------------------------------------------------------------------------------------------

def of_cpp(text):
    """Each string of C++, pieces joined that the compiler or + or << joins; what is not text between them is a place to fill in."""
    text = re.sub(r"(?m)^\s*//.*$", "", text)
    found, said, end = [], None, 0
    for literal in re.finditer(r'"((?:\\.|[^"\\\n])*)"', text):
        gap = text[end:literal.start()]
        if said is not None and not gap.strip():
            said += literal.group(1)
        elif said is not None and re.fullmatch(r"\s*(\+|<<)[^;,{}]*(\+|<<)\s*", gap):
            said += PLACE + literal.group(1)
        else:
            if said is not None:
                found.append(said + (PLACE if re.match(r"\s*(\+|<<)", gap) else ""))
            said = literal.group(1)
        end = literal.end()
    found.append(said or "")
    return [re.sub(r"%[-0-9.]*l*[sdufgz]+|\{\}", PLACE, each).replace(r"\n", "\n").replace(r"\"", '"') for each in found]


def of_script(text):
    """The lines of Python, JavaScript or shell; what is filled in there stands in braces. ` ends a string of JavaScript."""
    text = re.sub(r'"\s*\n\s*f?"', "", text)  # one string, over lines
    return [re.sub(r"\$?\{[^{}]*\}|%\(\w+\)s", PLACE, text).replace("`", '"')]


def of_manual(text):
    """Commands that a manual page shows line by line, and those in bold. The synopsis shows no command but its form."""
    text = re.sub(r"(?ms)^\.SH SYNOPSIS.*?(?=^\.SH )", "", text).replace(r"\-", "-")
    shown = [line for block in re.findall(r"(?ms)^\.nf\n(.*?)^\.fi", text) for line in block.splitlines()]
    bold = re.findall(r'(?m)^\.BR? "?((?:haptic)[^"\n]*)', text)
    plain = [re.sub(r"\\f[A-Z]", "", line) for line in shown + bold]
    return [f"`{line}`" for line in plain if NAMED.search(line) and not re.search(r" \(\d", line)]


def of_page(text):
    """Commands of Markdown: in blocks, a line each, and in the text between `."""
    lines = [line.split(" # ")[0].strip() for block in re.findall(r"(?ms)^```\w*\n(.*?)^```", text) for line in block.splitlines()]
    inline = re.findall(r"`([^`\n]+)`", re.sub(r"(?ms)^```.*?^```", "", text))
    plain = [re.sub(r"\[(-[^\]]*)\]", r"\1", IN_BUILD.sub("", line)) for line in lines + inline]
    return [f"`{line}`" for line in plain if NAMED.match(line)]


READERS = {".cpp": of_cpp, ".h": of_cpp, ".py": of_script, ".js": of_script, "": of_script, ".1": of_manual, ".md": of_page}


def texts_of(repository):
    """(file, text) for all that may tell people what to run; tests tell nobody."""
    listed = subprocess.run(["git", "-C", repository, "ls-files"], capture_output=True, text=True, check=True).stdout.split("\n")
    for name in listed:
        path = repository / name
        if name.startswith(("tests/", ".")) or path.suffix not in READERS or not path.is_file() or name == "CHANGELOG.md":
            continue
        if path.suffix == "" and not path.read_bytes().startswith(b"#!"):
            continue
        for text in READERS[path.suffix](path.read_text(encoding="utf-8")):
            yield name, text


# --- What programs know --------------------------------------------------------------------------------------------------------------

class Command:
    """A program, or one of its commands, as its --help describes it."""

    def __init__(self, run_help, words):
        self.words, self._run_help = words, run_help
        self.help = run_help(words)
        self.options = {}
        for names, kind in re.findall(r"(?m)^ {1,4}((?:-\w, ?)?--[\w-]+|-\w,--[\w-]+)((?: \S+)*)", self.help):
            self.options[names.split(",")[-1].strip()] = re.sub(r"(Excludes|Needs): .*", "", kind).strip()
        _, _, listed = self.help.partition("\nSubcommands:\n")
        argparse = re.search(r"(?ms)^positional arguments:\n  COMMAND\n(.*?)^\S", self.help)
        self.names = re.findall(r"(?m)^ {2,4}([a-z]+)(?: |$)", listed or (argparse.group(1) if argparse else ""))
        self.is_group = bool(self.names)
        if not self.names and len(words) == 1:  # in prose
            self.names = [word for word in sorted(set(re.findall(rf"\b{words[0]} ([a-z]+)", self.help)))
                          if re.search(rf"(?m)^Usage: {words[0]} {word}\b", run_help([*words, word]))]
        usage = re.search(r"(?mi)^usage: [^\n]*(?:\n  +[^\n]*)*", self.help)
        plain = usage.group() if usage else ""
        while "[" in plain and plain != (plain := re.sub(r"\[[^\[\]]*\]", "", plain)):
            pass
        needed = r"(--[\w-]+) ([A-Z]+)"
        self.required = {**dict(re.findall(needed, plain)), **{name: kind for name, kind in self.options.items() if "REQUIRED" in kind}}
        plain = re.sub(needed, "", plain)
        self.arguments = [word for word in re.findall(r"\b[A-Z][A-Z=]+\b", plain) if word not in ("SUBCOMMAND", "COMMAND", "OPTIONS")]
        if "[FILE]" in self.help or "..." in (usage.group() if usage else ""):
            self.arguments.append("MORE")
        self.is_complete = not self.arguments and not self.required and "[Exactly 1" not in self.help
        self._below = {}

    def below(self, name):
        if name not in self._below:
            inner = Command(self._run_help, [*self.words, name])
            inner.options = {**self.options, **inner.options}
            self._below[name] = inner
        return self._below[name]


def is_place(word):
    """For what the reader or the program puts something of their own."""
    return PLACE in word or bool(re.fullmatch(r"<?[A-Z][A-Z_.:=]*>?(\.\.\.)?|\w+:FILE|HOST:\d+", word))


def filled(word, kind, values):
    """A word that can be run: `kind` is what the help calls it; `values` has what stands for each kind of place."""
    if not is_place(word):
        return word
    if PLACE not in word and "=" not in word and word in values:
        return values[word]
    first = kind.split("|")[0].split("=")[0].split("{")[0].split(" ")[0]
    named = re.sub(r":.*", "", first) if first.startswith(("INT", "UINT", "FLOAT")) else first
    return values.get(named, values.get(word, named if named and named.islower() else values["TEXT"]))


class Found(Exception):
    """What is wrong with a command that people are told to run."""


def cut(text):
    """Words of a text after a program's name, each with whether a sentence or a quotation ends with it."""
    for word in re.split(r"[ \n]+", text):
        if not word:
            continue
        bare = re.sub(r"[`\"].*$|(?<=\w)['’].*$", "", word.replace("...", ""))
        bare = re.sub(rf"^{PLACE}(?=[a-z])", "", bare)  # options, each with a blank behind it
        bare = bare.rstrip(".,;:)!?" if "[" in bare else ".,;:)!?]")
        yield bare, not word.endswith(bare)
        if not word.endswith(bare):
            return


def command_in(text, start, program, values, strict):
    """The command at `start` of a text, its places filled in, or None where the program is only spoken of.

    `strict`: it stands between quotation marks, and all of it belongs to it."""
    at, words, rest = program, [program.words[0]], list(cut(text[start:]))
    told, bare = False, True
    while rest and rest[0][0] in at.names:
        (word, _), *rest = rest
        at, told = at.below(word), True
        words.append(word)
    places = list(at.arguments)
    if rest and at.names and not rest[0][0].startswith("-"):
        close = difflib.get_close_matches(rest[0][0], at.names, 1, TOLERATED)
        if rest[0][0] and (close or strict) and not is_place(rest[0][0]):
            raise Found(f"there is no {' '.join(words)} {rest[0][0]}")
        return None
    while rest:
        (word, _), *rest = rest
        if word in at.names:
            at = at.below(word)
            words.append(word)
            places = list(at.arguments)
            continue
        if word == "--":
            words += ["--", *(each for each, _ in rest)]
            break
        if re.match(r"--?\w", word):
            told, bare = True, False
            name, _, value = word.partition("=")
            kind = at.options.get(name, at.options.get({"-o": "--output"}.get(name, ""), None))
            if kind is None and name not in ("-h", "--help"):
                raise Found(f"{' '.join(words)} has no option {name}")
            words.append(word if not value else f"{name}={filled(value, kind or '', values)}")
            if kind and not value:
                (value, _), *rest = rest or [(PLACE, True)]
                words.append(filled(value, kind, values))
        elif places and (strict or is_place(word) or re.search(r"[\d./_=\[]", word)):
            words.append(filled(word, places[0], values))
            bare = False
            places = places if places[0] == "MORE" else places[1:]
        elif strict and word not in ("", PLACE):
            raise Found(f"{' '.join(words)} takes no {word}")
        else:
            break
    if not told or at.is_group:
        return None
    if bare and not at.is_complete:
        return [*words, "--help"]  # a command that is spoken of
    words += [filled(PLACE, place, values) for place in places if place != "MORE"]
    given = {"--output" if word == "-o" else word.partition("=")[0] for word in words}
    for name, kind in at.required.items():
        words += [] if name in given or "--help" in given else [name, filled(PLACE, kind, values)]
    return words


def commands_in(text, program_of, values):
    """(words of a command, None) or (None, what is wrong) for each command in a text."""
    for named in NAMED.finditer(text):
        if named.group(1) not in program_of:
            continue  # not built
        before = text[max(0, named.start() - 1):named.start()]
        quoted = before in ("`", "'")
        part = text[named.end():]
        if quoted:
            part = re.split(re.escape(before) + r"(?!\w)|&&| \| | > |(?<= )#", part)[0]
            try:
                part = " ".join(shlex.split(part))
            except ValueError:
                pass
        try:
            words = command_in(part, 0, program_of[named.group(1)], values, quoted)
        except Found as wrong:
            yield None, str(wrong)
            continue
        if words:
            yield words, None
