# Replays random scripts with --verify and both kernels: every update equals a rebuild. The scripts
# are the same bytes for the same seed.
file(READ ${DATA}/scenes.json index)
foreach(name IN LISTS NAMES)
  string(JSON light GET "${index}" ${name}.obj light)
  string(REPLACE "point:" "" at ${light})
  foreach(seed RANGE 1 ${SEEDS})
    foreach(file IN ITEMS edits.jsonl again.jsonl)
      execute_process(COMMAND ${MAKE_EDITS} ${DATA}/${name}.obj ${seed} ${COUNT} --light=${at}
        OUTPUT_FILE ${FOLDER}/${file} COMMAND_ERROR_IS_FATAL ANY)
    endforeach()
    execute_process(COMMAND ${CMAKE_COMMAND} -E compare_files ${FOLDER}/edits.jsonl
      ${FOLDER}/again.jsonl COMMAND_ERROR_IS_FATAL ANY)
    foreach(kernel IN ITEMS fast exact)
      execute_process(COMMAND ${SHADOWCUT} replay ${DATA}/${name}.obj ${FOLDER}/edits.jsonl
        --light ${light} --kernel ${kernel} --verify --quiet
        RESULT_VARIABLE status ERROR_VARIABLE message)
      if(NOT status EQUAL 0)
        message(FATAL_ERROR "${name}, seed ${seed}, ${COUNT} edits, ${kernel}: ${message}")
      endif()
    endforeach()
  endforeach()
endforeach()
