"""No type is defined twice in one namespace: two of one name in one program are undefined behaviour, and confusing
where they are in none."""
import collections
import pathlib
import re
import tempfile
import unittest

PROJECT = pathlib.Path(__file__).resolve().parents[2]
FOLDERS = ("format", "writer", "runtime", "baker", "tools", "python")
OPEN = re.compile(r"^namespace(?: ([A-Za-z_:]+))? \{$")
CLOSE = re.compile(r"^\}  // namespace")
# At the beginning of a line: one inside another type is a name of that type's own.
TYPE = re.compile(r"^(?:struct|class|union|enum class|enum)(?: alignas\([^)]*\))? ([A-Za-z_]\w*)(?: final)?(?: : [^;{]*)? ?\{")
SPECIALIZED = re.compile(r"^template <>")


def types_of(text):
    """(namespace, name) of the types that a file defines. What is in an unnamed namespace is the file's own."""
    namespaces, before = [], ""
    for line in text.splitlines():
        if match := OPEN.match(line):
            namespaces.append(match.group(1))
        elif CLOSE.match(line) and namespaces:
            namespaces.pop()
        elif (match := TYPE.match(line)) and None not in namespaces and not SPECIALIZED.match(before):
            yield "::".join(namespaces), match.group(1)
        before = line


def defined_twice(project, folders=FOLDERS):
    where = collections.defaultdict(set)
    for folder in folders:
        for suffix in ("h", "cpp"):
            for path in (project / folder).rglob(f"*.{suffix}"):
                for name in types_of(path.read_text()):
                    where[name].add(str(path.relative_to(project)))
    return [f"{namespace}::{name} is defined in {' and in '.join(sorted(paths))}"
            for (namespace, name), paths in sorted(where.items()) if len(paths) > 1]


class Names(unittest.TestCase):
    def test_no_type_is_defined_twice(self):
        found = defined_twice(PROJECT)
        self.assertFalse(found, "\n" + "\n".join(found))

    def test_twins_are_found(self):
        with tempfile.TemporaryDirectory() as folder:
            project = pathlib.Path(folder)
            (project / "a").mkdir()
            (project / "a/one.h").write_text("namespace vcd {\nstruct View {\n};\nnamespace {\nclass Own {\n};\n}  // namespace\n}  // namespace vcd\n")
            (project / "a/two.cpp").write_text("namespace vcd {\nnamespace {\nclass Own {\n};\n}  // namespace\nclass View : public Own {\n};\n}  // namespace vcd\n")
            (project / "a/three.h").write_text("namespace vcd::other {\nstruct View {\n};\nstruct Later;\n}  // namespace vcd::other\n")
            self.assertEqual(defined_twice(project, ["a"]), ["vcd::View is defined in a/one.h and in a/two.cpp"])


if __name__ == "__main__":
    unittest.main()
