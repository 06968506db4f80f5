// tinygltf, as this folder uses it: no image is decoded, no file is opened.
//
// The namespace has a name of its own, since a program that links the baker may hold a tinygltf built otherwise.
#pragma once

#define TINYGLTF_NO_STB_IMAGE
#define TINYGLTF_NO_STB_IMAGE_WRITE
#define TINYGLTF_NO_EXTERNAL_IMAGE
#define TINYGLTF_NO_FS
#define tinygltf vcd_tinygltf
#include <tiny_gltf.h>
#undef tinygltf

namespace vcd::baker {
namespace tinygltf = ::vcd_tinygltf;
}
