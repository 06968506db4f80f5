# vcd_describe_program(PROGRAM): its man page and its completions of bash, zsh and fish, printed by itself after it is built,
# in share/ of the build tree, and installed where man and the shells look.
function(vcd_describe_program program)
  if(CMAKE_CROSSCOMPILING AND NOT CMAKE_CROSSCOMPILING_EMULATOR)
    return()
  endif()
  set(man share/man/man1/${program}.1)
  set(bash share/bash-completion/completions/${program})
  set(zsh share/zsh/site-functions/_${program})
  set(fish share/fish/vendor_completions.d/${program}.fish)
  set(files ${man} ${bash} ${zsh} ${fish})
  foreach(file ${files})
    get_filename_component(folder ${CMAKE_BINARY_DIR}/${file} DIRECTORY)
    file(MAKE_DIRECTORY ${folder})
    get_filename_component(folder ${file} DIRECTORY)
    string(REGEX REPLACE "^share" "${CMAKE_INSTALL_DATAROOTDIR}" folder ${folder})
    install(FILES ${CMAKE_BINARY_DIR}/${file} DESTINATION ${folder})
  endforeach()
  add_custom_command(
    OUTPUT ${CMAKE_BINARY_DIR}/${man} ${CMAKE_BINARY_DIR}/${bash} ${CMAKE_BINARY_DIR}/${zsh} ${CMAKE_BINARY_DIR}/${fish}
    COMMAND ${program} --print-man > ${man}
    COMMAND ${program} --print-completion bash > ${bash}
    COMMAND ${program} --print-completion zsh > ${zsh}
    COMMAND ${program} --print-completion fish > ${fish}
    DEPENDS ${program}
    WORKING_DIRECTORY ${CMAKE_BINARY_DIR}
    COMMENT "Describing ${program}"
    VERBATIM)
  add_custom_target(${program}-description ALL DEPENDS ${CMAKE_BINARY_DIR}/${man})
endfunction()
