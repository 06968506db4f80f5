# vcd_bake(TARGET MESH... [OPTIONS OPTION...] [OUTPUT_DIRECTORY FOLDER] [ALL])
#
# Adds TARGET, which bakes a sidecar of each mesh, FOLDER/MESH.vcd. A sidecar is baked again when its mesh changes, a file
# that the mesh names (the .bin of a glTF), or an option; not when vc-bake does.
#
#   MESH              a file, relative to the current source folder; it may be made by the build
#   OPTIONS           for vc-bake, such as --method proven
#   OUTPUT_DIRECTORY  relative to the current binary folder, which is the default; ${CMAKE_CURRENT_SOURCE_DIR}: beside
#   ALL               bake with the default target
#
# The property VCD_SIDECARS of TARGET is the list of sidecars. Generators: Ninja, Makefiles, and those of Visual Studio and Xcode.
#
# Names may hold any characters but line ends and backslashes. Where the generator's rules cannot hold a name, the sidecar is
# no output of a rule, so that others depend on TARGET instead, and the mesh must be there when CMake runs.
function(vcd_bake target)
  if(NOT TARGET vcd::vc-bake)
    message(FATAL_ERROR "vcd_bake(${target}): vc-bake is not installed; build vcd with VCD_BUILD_BAKER")
  endif()
  # By hand: as elements of lists, names with semicolons and brackets would be parted or joined.
  set(all "")
  set(folder "")
  set(options "")
  set(mesh_count 0)
  set(kind MESH)
  math(EXPR last "${ARGC} - 1")
  foreach(i RANGE 1 ${last})
    if(i GREATER last)
      break()  # there is no MESH
    endif()
    set(word "${ARGV${i}}")
    if(word STREQUAL "ALL")
      set(all ALL)
      set(kind MESH)
    elseif(word MATCHES "^(OPTIONS|OUTPUT_DIRECTORY)$")
      set(kind ${word})
    elseif(kind STREQUAL "OPTIONS")
      string(REPLACE ";" "\\;" word "${word}")
      list(APPEND options "${word}")
    elseif(kind STREQUAL "OUTPUT_DIRECTORY")
      set(folder "${word}")
      set(kind MESH)
    else()
      set(mesh_${mesh_count} "${word}")
      math(EXPR mesh_count "${mesh_count} + 1")
    endif()
  endforeach()
  if(mesh_count EQUAL 0)
    message(FATAL_ERROR "vcd_bake(${target}): no mesh")
  endif()
  cmake_path(ABSOLUTE_PATH folder BASE_DIRECTORY "${CMAKE_CURRENT_BINARY_DIR}" NORMALIZE)

  set(sidecars "")
  set(outputs "")
  math(EXPR last "${mesh_count} - 1")
  foreach(i RANGE ${last})
    set(mesh "${mesh_${i}}")
    cmake_path(ABSOLUTE_PATH mesh BASE_DIRECTORY "${CMAKE_CURRENT_SOURCE_DIR}" NORMALIZE)
    cmake_path(GET mesh FILENAME name)
    cmake_path(APPEND folder "${name}.vcd" OUTPUT_VARIABLE sidecar)
    string(SHA256 id "${sidecar}")
    if(DEFINED baked_${id})
      message(FATAL_ERROR "vcd_bake(${target}): two meshes would be baked into ${sidecar}")
    endif()
    set(baked_${id} TRUE)
    _vcd_bake_one("${target}" "${mesh}" "${sidecar}" "${options}" output)
    list(APPEND outputs "${output}")
    string(REPLACE ";" "\\;" sidecar "${sidecar}")
    list(APPEND sidecars "${sidecar}")
  endforeach()
  add_custom_target(${target} ${all} DEPENDS ${outputs})
  set_target_properties(${target} PROPERTIES VCD_SIDECARS "${sidecars}")
endfunction()

# The rule of one sidecar; sets the variable `output` to what stands for the sidecar in rules. Rules and dependency files of
# the generators hold plain names. Where a name is not plain, a stamp stands for the sidecar, beside it where that is
# possible, and a link for the mesh.
function(_vcd_bake_one target mesh sidecar options output)
  if("${mesh}${sidecar}" MATCHES "[\n\r\\\\]")
    message(FATAL_ERROR "vcd_bake(${target}): ${mesh}: a name must not hold a line end or a backslash")
  endif()
  set(plain "^[-A-Za-z0-9_./+,=@]+$")
  set(no_rule "[][#<>|;\"]|\\$\\(")
  if(CMAKE_GENERATOR MATCHES "Makefiles")
    set(no_rule "[][#<>|;\"%*?:]|\\$\\(")  # what would be a pattern
  endif()
  string(SHA256 id "${sidecar}")
  string(SUBSTRING "${id}" 0 16 id)
  set(made CMakeFiles/vcd_bake/${id})  # in the current binary folder, where the rule runs
  file(MAKE_DIRECTORY "${CMAKE_CURRENT_BINARY_DIR}/CMakeFiles/vcd_bake")

  set(outputs ${made}.stamp)
  set(stamp COMMAND ${CMAKE_COMMAND} -E touch ${made}.stamp)
  if("${mesh}${sidecar}${CMAKE_CURRENT_BINARY_DIR}" MATCHES "${plain}")
    set(outputs "${sidecar}")
    set(stamp "")
  elseif(NOT sidecar MATCHES "${no_rule}")
    list(APPEND outputs "${sidecar}")
  endif()
  list(GET outputs 0 first)

  set(depends "")
  if(NOT mesh MATCHES "${no_rule}")
    list(APPEND depends "${mesh}")
  elseif(NOT EXISTS "${mesh}")
    message(FATAL_ERROR "vcd_bake(${target}): ${mesh}: is not there, and the build cannot make it, since no rule of "
                        "${CMAKE_GENERATOR} can hold the name")
  endif()
  if(NOT mesh MATCHES "${plain}" AND EXISTS "${mesh}")
    file(CREATE_LINK "${mesh}" "${CMAKE_CURRENT_BINARY_DIR}/${made}.mesh" SYMBOLIC)
    list(APPEND depends "${CMAKE_CURRENT_BINARY_DIR}/${made}.mesh")
  endif()

  # The names in a file, so that no shell sees them; and the options in one, so that Make sees a change of them.
  set(names "${mesh}\n-o\n${sidecar}\n--depfile\n${made}.d\n--depfile-target\n${first}\n--quiet\n")
  foreach(file names options)
    set(path "${CMAKE_CURRENT_BINARY_DIR}/${made}.${file}")
    set(old "")
    if(EXISTS "${path}")
      file(READ "${path}" old)
    endif()
    if(NOT EXISTS "${path}" OR NOT old STREQUAL "${${file}}")
      file(WRITE "${path}" "${${file}}")
    endif()
    list(APPEND depends "${path}")
  endforeach()

  cmake_path(GET sidecar FILENAME name)
  cmake_path(GET sidecar PARENT_PATH folder)
  file(MAKE_DIRECTORY "${folder}")
  set(make_folder COMMAND ${CMAKE_COMMAND} -E make_directory "${folder}")  # once more, where it was removed
  if(folder MATCHES "${no_rule}")
    set(make_folder "")
  endif()
  cmake_policy(PUSH)
  cmake_policy(SET CMP0116 NEW)  # Ninja gets paths in depfiles as it knows them
  add_custom_command(
    OUTPUT ${outputs}
    ${make_folder}
    COMMAND vcd::vc-bake @${made}.names ${options}
    ${stamp}
    DEPENDS ${depends}
    DEPFILE ${made}.d
    COMMENT "Baking ${name}"
    VERBATIM)
  cmake_policy(POP)
  set(${output} "${first}" PARENT_SCOPE)
endfunction()
