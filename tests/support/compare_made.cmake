# Runs make_scenes into a fresh folder and compares with data/, byte by byte.
file(REMOVE_RECURSE ${FOLDER})
file(MAKE_DIRECTORY ${FOLDER})
execute_process(COMMAND ${MAKE_SCENES} ${FOLDER} COMMAND_ERROR_IS_FATAL ANY)
file(GLOB made RELATIVE ${FOLDER} ${FOLDER}/*)
foreach(file IN LISTS made)
  execute_process(COMMAND ${CMAKE_COMMAND} -E compare_files ${FOLDER}/${file} ${DATA}/${file}
    RESULT_VARIABLE different)
  if(different)
    message(FATAL_ERROR "data/${file} is not what make_scenes writes")
  endif()
endforeach()
