"""Holds the layers: which folder may include which, and which foreign library."""
import os
import pathlib
import re
import tempfile
import unittest

PROJECT = pathlib.Path(__file__).resolve().parents[2]

# Folder: the folders and the foreign libraries that it may include, besides itself, C++ and the system. The longest
# folder that a file lies in is its own. A library is named by the first part of the include.
LAYERS = {
    "format": ({}, {"xxhash.h", "zstd.h"}),
    "writer": ({"format"}, {"xxhash.h", "zstd.h"}),
    "runtime": ({"format"}, {"hwy"}),
    "preload": ({"format", "runtime"}, {"embree3", "xxhash.h"}),
    "recorder": ({"format", "writer", "runtime"}, set()),
    "baker": ({"format", "writer", "baker/ingest"},
              {"embree3", "hwy", "tbb", "xxhash.h", "nlohmann", "draco"}),
    "baker/ingest": ({"format", "baker"}, {"draco", "meshoptimizer.h", "nlohmann", "OpenMesh", "tiny_gltf.h", "xxhash.h"}),
    "tools/common": ({"format", "writer", "runtime", "baker"}, {"CLI", "nlohmann"}),
    "tools/library": ({"format", "writer", "runtime", "recorder", "baker", "tools/common"}, {"nlohmann", "tbb"}),
    "tools/verify": ({"format", "writer", "runtime", "baker", "tools/common", "tools/library"},
                     {"nlohmann", "pugixml.hpp", "tbb"}),
    "tools/bake": ({"format", "writer", "runtime", "baker", "tools/common", "tools/library"}, {"CLI", "nlohmann"}),
    "tools/info": ({"format", "writer", "baker", "tools/common"},
                   {"meshoptimizer.h", "nlohmann", "png.h", "stb_easy_font.h", "zlib.h"}),
    "tools/lab/scenes": ({}, {"tiny_gltf.h"}),
    "tools/lab/render": ({"format", "writer", "runtime", "recorder", "baker", "tools/common", "tools/lab/scenes"},
                         {"CLI", "hwy", "embree3", "nlohmann", "png.h", "stb_easy_font.h", "ImfChannelList.h",
                          "ImfFrameBuffer.h", "ImfHeader.h", "ImfIO.h", "ImfOutputFile.h"}),
    "tools/lab/bench": ({"format", "writer", "runtime", "recorder", "baker", "tools/common", "tools/library", "tools/lab/scenes", "tools/lab/render"},
                        {"CLI", "embree3", "nlohmann"}),
    "python": ({"format", "writer", "runtime", "baker", "tools/library", "tools/verify"}, {"pybind11"}),
    # Programs and what else a program alone needs: everything below them, but nothing of the lab.
    "tools": ({"format", "writer", "runtime", "baker", "tools/common", "tools/library", "tools/verify", "tools/bake", "tools/info"},
              {"CLI", "nlohmann", "pugixml.hpp", "tbb"}),
    "tools/lab": ({"format", "writer", "runtime", "recorder", "baker", "tools/common", "tools/library", "tools/bake",
                   "tools/lab/scenes", "tools/lab/render", "tools/lab/bench"}, {"CLI", "embree3", "nlohmann"}),
}
# Public headers that name no foreign library at all: programs of others include them.
CLEAN_HEADERS = ("format/include", "writer/include", "runtime/include", "recorder/include", "tools/library/include", "tools/verify/include",
                 "baker/include/vcd/baker/bake_sidecar.h")
# Where an include in quotes or of <vcd/...> may lie, besides beside the file.
ROOTS = ["format/include", "format/src", "writer/include", "writer/src", "runtime/include", "runtime/src", "recorder/include",
         "baker/include", "baker", "tools/library/include", "tools/verify/include", "tools/lab/scenes/include",
         "tools/lab/scenes", "tools", "tools/lab"]
SYSTEM = re.compile(r"[a-z_0-9]+|(sys|linux)/[a-z_]+\.h|(dirent|dlfcn|errno|fcntl|fnmatch|poll|pthread|sched|signal|spawn|"
                    r"stddef|stdint|stdio|stdlib|string|termios|unistd)\.h")
INCLUDE = re.compile(r'^ *# *include *([<"])([^>"]+)[>"]', re.M)


def layer_of(path):
    return max((layer for layer in LAYERS if path.startswith(layer + "/")), key=len)


def breaches_of(project, path):
    """What a file includes and must not, one sentence each."""
    layer = layer_of(path)
    folders, libraries = LAYERS[layer]
    for bracket, name in INCLUDE.findall((project / path).read_text()):
        own = [str(pathlib.PurePosixPath(path).parent)] if bracket == '"' else []
        files = [f"{root}/{name}" for root in own + ROOTS if (project / root / name).is_file()]
        if files:
            other = layer_of(os.path.normpath(files[0]))
            if other != layer and other not in folders:
                yield f"{path} includes {name}: {layer} must not know {other}"
        elif bracket == '"' or name.startswith("vcd/"):
            yield f"{path} includes {name}, which is nowhere"
        elif not SYSTEM.fullmatch(name):
            library = name.split("/")[0]
            if library not in libraries or path.startswith(CLEAN_HEADERS):
                yield f"{path} includes {name}: not a library of {layer}"


def breaches(project):
    files = [path for layer in LAYERS for suffix in ("h", "cpp", "c") for path in (project / layer).rglob(f"*.{suffix}")]
    return [b for path in sorted(set(files)) for b in breaches_of(project, str(path.relative_to(project)))]


class Layers(unittest.TestCase):
    def test_every_file_keeps_to_its_layer(self):
        found = breaches(PROJECT)
        self.assertFalse(found, "\n" + "\n".join(found))

    def test_breaches_are_found(self):
        for path, line, known in (("runtime/src/a.cpp", "#include <vcd/baker/bake.h>", True),
                                  ("runtime/src/a.cpp", "#  include <embree3/rtcore.h>", False),
                                  ("runtime/include/vcd/runtime/a.h", "#include <hwy/highway.h>", False),
                                  ("format/src/a.cpp", "#include <vcd/runtime/sidecar.h>", True),
                                  ("tools/library/include/vcd/library/a.h", "#include <CLI/CLI.hpp>", False),
                                  ("tools/vc_bake.cpp", '#include "render/world.h"', True),
                                  ("baker/octree/a.cpp", '#include "missing.h"', False)):
            with self.subTest(path=path, line=line), tempfile.TemporaryDirectory() as folder:
                project = pathlib.Path(folder)
                targets = ["baker/include/vcd/baker/bake.h", "runtime/include/vcd/runtime/sidecar.h",
                           "tools/lab/render/world.h"]
                for target in targets if known else []:
                    (project / target).parent.mkdir(parents=True, exist_ok=True)
                    (project / target).touch()
                (project / path).parent.mkdir(parents=True, exist_ok=True)
                (project / path).write_text("#include <vector>\n#include <unistd.h>\n" + line + "\n")
                self.assertEqual(len(breaches(project)), 1)


if __name__ == "__main__":
    unittest.main()
