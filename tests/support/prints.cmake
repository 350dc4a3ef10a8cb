# Runs PROGRAM, which must print what the file PRINTS holds.
execute_process(COMMAND ${PROGRAM} OUTPUT_VARIABLE printed COMMAND_ERROR_IS_FATAL ANY)
file(READ ${PRINTS} wanted)
if(NOT printed STREQUAL wanted)
  message(FATAL_ERROR "it prints\n${printed}and should print\n${wanted}")
endif()
