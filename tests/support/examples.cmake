# The programs in docs/embedding.md: each fenced block of code is a program, and the next block of
# text is what it prints.

# Sets ${out} to what stands in the first block fenced as `language` of ${text}, and takes
# everything up to its end off ${text}.
macro(take_block language out)
  string(FIND "${text}" "\n```${language}\n" at)
  if(at EQUAL -1)
    message(FATAL_ERROR "docs/embedding.md has no ${language}")
  endif()
  string(LENGTH "\n```${language}\n" fence)
  math(EXPR at "${at} + ${fence}")
  string(SUBSTRING "${text}" ${at} -1 text)
  string(FIND "${text}" "\n```" at)
  math(EXPR at "${at} + 1")
  string(SUBSTRING "${text}" 0 ${at} ${out})
  string(SUBSTRING "${text}" ${at} -1 text)
endmacro()

# Writes the program to ${folder}/example.${language}, and what it prints to
# ${folder}/example.${language}.txt.
function(extract_example language folder)
  file(READ ${PROJECT_SOURCE_DIR}/docs/embedding.md text)
  take_block(${language} code)
  take_block(text prints)
  string(REGEX MATCHALL "\n" lines "${code}")
  list(LENGTH lines lines)
  if(lines GREATER_EQUAL 60)
    message(FATAL_ERROR "the ${language} example has ${lines} lines: it must have less than 60")
  endif()
  file(WRITE ${folder}/example.${language}.new "${code}")
  configure_file(${folder}/example.${language}.new ${folder}/example.${language} COPYONLY)
  file(WRITE ${folder}/example.${language}.txt "${prints}")
endfunction()

set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS
  ${PROJECT_SOURCE_DIR}/docs/embedding.md)
set(folder ${CMAKE_CURRENT_BINARY_DIR}/examples)
foreach(language IN ITEMS cpp c)
  extract_example(${language} ${folder})
  add_executable(example_${language} ${folder}/example.${language})
  target_link_libraries(example_${language} PRIVATE shadowcut_warnings)
  add_test(NAME example.${language}
    COMMAND ${CMAKE_COMMAND} -DPROGRAM=$<TARGET_FILE:example_${language}>
    -DPRINTS=${folder}/example.${language}.txt
      -P ${support}/prints.cmake)
endforeach()
target_link_libraries(example_cpp PRIVATE shadowcut::core)
target_link_libraries(example_c PRIVATE shadowcut::c)
set_target_properties(example_c PROPERTIES C_STANDARD 11 C_STANDARD_REQUIRED ON C_EXTENSIONS OFF)

# JavaScript's is run by Node (web.cmake), and finds the package as one that npm has installed.
extract_example(js ${folder})
file(WRITE ${folder}/package.json "{\"type\": \"module\"}\n")
file(MAKE_DIRECTORY ${folder}/node_modules)
file(CREATE_LINK ${PROJECT_SOURCE_DIR}/web/shadowcut ${folder}/node_modules/shadowcut SYMBOLIC)
