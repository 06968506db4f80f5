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
function(vcd_bake target)
  cmake_parse_arguments(PARSE_ARGV 1 arg ALL OUTPUT_DIRECTORY OPTIONS)
  if(NOT TARGET vcd::vc-bake)
    message(FATAL_ERROR "vcd_bake(${target}): vc-bake is not installed; build vcd with VCD_BUILD_BAKER")
  elseif(NOT arg_UNPARSED_ARGUMENTS)
    message(FATAL_ERROR "vcd_bake(${target}): no mesh")
  endif()
  set(all "")
  if(arg_ALL)
    set(all ALL)
  endif()
  set(folder "${arg_OUTPUT_DIRECTORY}")
  cmake_path(ABSOLUTE_PATH folder BASE_DIRECTORY ${CMAKE_CURRENT_BINARY_DIR} NORMALIZE)
  cmake_policy(PUSH)
  cmake_policy(SET CMP0116 NEW)  # Ninja gets paths in depfiles as it knows them
  set(sidecars "")
  foreach(mesh ${arg_UNPARSED_ARGUMENTS})
    cmake_path(ABSOLUTE_PATH mesh BASE_DIRECTORY ${CMAKE_CURRENT_SOURCE_DIR} NORMALIZE)
    cmake_path(GET mesh FILENAME name)
    cmake_path(APPEND folder ${name}.vcd OUTPUT_VARIABLE sidecar)
    if(sidecar IN_LIST sidecars)
      message(FATAL_ERROR "vcd_bake(${target}): two meshes would be baked into ${sidecar}")
    endif()
    list(APPEND sidecars ${sidecar})
    add_custom_command(
      OUTPUT ${sidecar}
      COMMAND ${CMAKE_COMMAND} -E make_directory ${folder}
      COMMAND vcd::vc-bake ${mesh} -o ${sidecar} --depfile ${sidecar}.d --quiet ${arg_OPTIONS}
      DEPENDS ${mesh}
      DEPFILE ${sidecar}.d
      COMMENT "Baking ${name}.vcd"
      VERBATIM)
  endforeach()
  cmake_policy(POP)
  add_custom_target(${target} ${all} DEPENDS ${sidecars})
  set_target_properties(${target} PROPERTIES VCD_SIDECARS "${sidecars}")
endfunction()
