# vcd_describe_program(PROGRAM SUMMARY): installs what man and the shells show of a program.
#
# The man page is made by help2man from --help where help2man is installed (Debian: help2man), else there is none; fish
# completes from it. bash and zsh complete from --help.
find_program(VCD_HELP2MAN help2man)
set(VCD_ZSH_COMPLETIONS zsh/site-functions CACHE STRING "Folder below share/ that zsh looks in; Debian's own packages use zsh/vendor-completions")

function(vcd_describe_program program summary)
  set(share ${CMAKE_BINARY_DIR}/share)
  file(WRITE ${share}/bash-completion/completions/${program} "complete -F _longopt ${program}\n")
  file(WRITE ${share}/zsh/site-functions/_${program} "#compdef ${program}\n_gnu_generic\n")
  install(FILES ${share}/bash-completion/completions/${program}
          DESTINATION ${CMAKE_INSTALL_DATAROOTDIR}/bash-completion/completions)
  install(FILES ${share}/zsh/site-functions/_${program}
          DESTINATION ${CMAKE_INSTALL_DATAROOTDIR}/${VCD_ZSH_COMPLETIONS})
  if(NOT VCD_HELP2MAN OR CMAKE_CROSSCOMPILING)
    return()
  endif()
  set(page ${share}/man/man1/${program}.1)
  file(MAKE_DIRECTORY ${share}/man/man1)
  add_custom_command(
    OUTPUT ${page}
    COMMAND ${VCD_HELP2MAN} --no-info --name=${summary} --version-string=${PROJECT_VERSION} ${ARGN}
            --output=${page} $<TARGET_FILE:${program}>
    DEPENDS ${program}
    COMMENT "Man page of ${program}"
    VERBATIM)
  add_custom_target(${program}-man-page ALL DEPENDS ${page})
  install(FILES ${page} DESTINATION ${CMAKE_INSTALL_MANDIR}/man1)
endfunction()
