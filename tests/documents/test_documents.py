"""The documents keep their own rules: links and named sections are there, lines are short, every sentence is tested."""
import pathlib
import re
import subprocess
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
FOLDERS = ["assets", "baker", "cmake", "format", "preload", "recorder", "runtime", "spec", "tests", "tools", "writer"]
CODE = {".h", ".cpp", ".py", ".cmake", ".txt", ".md"}
LONGEST_LINE = 100
STILL_LONG = {"vcd-format.md"}  # to be wrapped with its next change


def documents():
    return sorted(ROOT.glob("*.md")) + sorted((ROOT / "spec").glob("*.md"))


def texts():
    yield from documents()
    for folder in FOLDERS:
        yield from (path for path in (ROOT / folder).rglob("*") if path.suffix in CODE and path.is_file())


def prose(path):
    """Lines of a document with their numbers, without fenced blocks."""
    fenced = False
    for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1):
        if line.lstrip().startswith("```"):
            fenced = not fenced
        elif not fenced:
            yield number, line


def headings(path):
    return {line.lstrip("# ").strip() for _, line in prose(path) if line.startswith("#")}


def section_exists(document, name):
    """A heading, or a paragraph that begins with the name: *What rounding can do:*, **Methods.**"""
    if name in headings(document):
        return True
    return re.search(r"^[-*\s]*\*+" + re.escape(name) + r"[.:*]", document.read_text(encoding="utf-8"), re.MULTILINE)


class Documents(unittest.TestCase):
    def test_links_lead_somewhere(self):
        for path in documents():
            for number, line in prose(path):
                for target in re.findall(r"\[[^\]]{2,}\]\(([^)#]+)\)", line):
                    if not re.match(r"https?://", target):
                        self.assertTrue((path.parent / target).exists(), f"{path.name}:{number}: {target}")

    def test_documents_that_are_named_exist(self):
        for path in texts():
            for name in re.findall(r"\bspec/([a-z-]+\.md)", path.read_text(encoding="utf-8", errors="replace")):
                self.assertTrue((ROOT / "spec" / name).exists(), f"{path.relative_to(ROOT)}: spec/{name}")

    def test_sections_that_are_named_exist(self):
        # spec/NAME.md, "Section" or [NAME.md](NAME.md), "Section"; a comment may break the line in between.
        pattern = re.compile(r'\b([a-z-]+\.md)\)?,?[\s/*#]+"([^"]+)"')
        seen = 0
        for path in texts():
            if path == pathlib.Path(__file__).resolve():
                continue
            for document, section in pattern.findall(path.read_text(encoding="utf-8", errors="replace")):
                name = re.sub(r"[\s/*#]+", " ", section)
                target = ROOT / "spec" / document
                if target.exists():
                    self.assertTrue(section_exists(target, name), f"{path.relative_to(ROOT)}: {document}, {name!r}")
                    seen += 1
        self.assertGreater(seen, 10)

    def test_lines_are_short(self):
        for path in documents():
            for number, line in prose(path):
                if not line.startswith("|") and path.name not in STILL_LONG:
                    self.assertLessEqual(len(line), LONGEST_LINE, f"{path.name}:{number}")

    def test_every_sentence_of_the_conventions_has_a_test(self):
        sentences = {int(n) for _, line in prose(ROOT / "spec/conventions.md") for n in re.findall(r"^(\d+)\. ", line)}
        self.assertEqual(sentences, set(range(1, 31)))
        source = "".join((ROOT / "tests" / test).read_text(encoding="utf-8")
                         for test in ("format/conventions_test.cpp", "runtime/horizon_test.cpp"))
        names = re.findall(r"TEST_F\(\w+, (\w+)\)", source)
        tested = {int(n) for name in names for n in re.findall(r"S(\d\d)_", name)}
        self.assertEqual(tested, sentences)

    def test_commits_in_results_exist(self):
        git = subprocess.run(["git", "-C", ROOT, "rev-parse", "--is-shallow-repository"], capture_output=True, text=True)
        if git.returncode != 0 or git.stdout.strip() != "false":
            self.skipTest("no history here")
        text = (ROOT / "spec/results.md").read_text(encoding="utf-8")
        commits = set(re.findall(r"\b(?=[0-9a-f]*\d)[0-9a-f]{7}\b", text))
        self.assertGreater(len(commits), 10)
        for commit in commits:
            found = subprocess.run(["git", "-C", ROOT, "cat-file", "-e", f"{commit}^{{commit}}"], capture_output=True)
            self.assertEqual(found.returncode, 0, commit)


if __name__ == "__main__":
    unittest.main()
