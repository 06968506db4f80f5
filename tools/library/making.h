// What a sidecar says about its making: its provenance, which is part of its bytes and from which a later run tells
// whether it is still what a bake would write.
#pragma once

#include <map>
#include <string>
#include <string_view>
#include <vector>

#include <vcd/baker/source.h>
#include <vcd/format/contents.h>

#include "assets.h"

namespace vcd {

std::string baker_text();  // program, version, kBakeRevision
std::string settings_text(const BakeSettings& settings);

// sources   the files that were read, the mesh file first
// left_out  for each object that lacks parts of its source a line "SOURCE_INDEX not-opaque=N deforming=N"
std::map<std::string, std::string> provenance_of(const Asset& asset, const std::vector<SourceFile>& sources,
                                                 const std::string& left_out = {});

std::string_view provenance_value(const SidecarContents& sidecar, std::string_view key);  // empty where there is none

// The files that the mesh file named when the sidecar was made of it.
std::vector<SourceFile> dependencies_of(const SidecarContents& sidecar);

// Why the sidecar is not what a bake of these files would write, a clause; empty if it is. Hashes the files.
std::string why_outdated(const Asset& asset, const SidecarContents& sidecar);

}  // namespace vcd
