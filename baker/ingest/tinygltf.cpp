#include <fstream>  // its writer uses that, and includes it with its file functions only

#define TINYGLTF_IMPLEMENTATION
#include "ingest/tinygltf.h"
