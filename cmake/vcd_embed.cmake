# cmake -DOUTPUT=FILE.cpp -DHEADER=FILE.h -DNAMESPACE=NAME "-DFILES=kName=FILE;…" -P vcd_embed.cmake
#
# Writes text files as C++ texts: HEADER declares them, as std::string_view in NAMESPACE.
file(WRITE ${OUTPUT} "#include \"${HEADER}\"\n\nnamespace ${NAMESPACE} {\nusing namespace std::string_view_literals;\n")
foreach(entry IN LISTS FILES)
  string(REGEX MATCH "^([^=]*)=(.*)$" all "${entry}")
  file(READ "${CMAKE_MATCH_2}" text)
  file(APPEND ${OUTPUT} "const std::string_view ${CMAKE_MATCH_1} = R\"_vcd_(${text})_vcd_\"sv;\n")
endforeach()
file(APPEND ${OUTPUT} "}  // namespace ${NAMESPACE}\n")
