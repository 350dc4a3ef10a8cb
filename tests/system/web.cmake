# The engine in WebAssembly: the package's tests, by Node.
if(SHADOWCUT_WEB AND NOT CMAKE_CXX_FLAGS MATCHES "-fsanitize")
  find_program(SHADOWCUT_NODE NAMES node nodejs REQUIRED)
  set(web ${PROJECT_SOURCE_DIR}/web/shadowcut)
  add_executable(web_reference ${support}/web_reference.cpp)
  target_link_libraries(web_reference PRIVATE shadowcut_testing shadowcut_warnings)
  set(reference ${CMAKE_CURRENT_BINARY_DIR}/web_reference.json)
  add_test(NAME web.build COMMAND ${CMAKE_COMMAND} -P ${support}/web_build.cmake
    WORKING_DIRECTORY ${PROJECT_SOURCE_DIR})
  add_test(NAME web.reference COMMAND web_reference ${reference})
  add_test(NAME web.is_native_to_the_bit COMMAND ${SHADOWCUT_NODE} --test
    ${web}/test/native.test.mjs)
  add_test(NAME web.package COMMAND ${SHADOWCUT_NODE} --test ${web}/test/package.test.mjs)
  add_test(NAME example.js COMMAND ${CMAKE_COMMAND}
    "-DPROGRAM=${SHADOWCUT_NODE};${folder}/example.js"
    -DPRINTS=${folder}/example.js.txt -P ${support}/prints.cmake)
  set_tests_properties(web.build PROPERTIES FIXTURES_SETUP web_module TIMEOUT 1200)
  set_tests_properties(web.reference PROPERTIES FIXTURES_SETUP web_reference TIMEOUT ${patience})
  set_tests_properties(web.is_native_to_the_bit PROPERTIES
    FIXTURES_REQUIRED "web_module;web_reference" TIMEOUT ${patience}
    ENVIRONMENT SHADOWCUT_REFERENCE=${reference})
  set_tests_properties(web.package example.js PROPERTIES FIXTURES_REQUIRED web_module
    TIMEOUT ${patience})

  if(SHADOWCUT_BROWSER)
    # The adapter for three.js; one test draws, in a browser.
    find_program(SHADOWCUT_NPM npm REQUIRED)
    find_program(SHADOWCUT_CHROMIUM NAMES chromium google-chrome REQUIRED)
    add_test(NAME web.install COMMAND ${CMAKE_COMMAND} -P ${PROJECT_SOURCE_DIR}/web/install.cmake)
    set_tests_properties(web.install PROPERTIES FIXTURES_SETUP web_packages TIMEOUT ${patience})
    foreach(name IN ITEMS adapter follow picture)
      add_test(NAME three.${name} COMMAND ${SHADOWCUT_NODE} --test
        ${PROJECT_SOURCE_DIR}/web/three/test/${name}.test.mjs)
      set_tests_properties(three.${name} PROPERTIES FIXTURES_REQUIRED "web_module;web_packages"
        TIMEOUT ${patience} ENVIRONMENT SHADOWCUT_CHROMIUM=${SHADOWCUT_CHROMIUM})
    endforeach()

    # The walkthrough, in the browser, beside the native program; and what that writes as glTF.
    if(SHADOWCUT_CLI)
      set(walkthrough ${PROJECT_SOURCE_DIR}/web/walkthrough)
      add_test(NAME walkthrough.build COMMAND ${SHADOWCUT_NPM} run build
        WORKING_DIRECTORY ${walkthrough})
      set_tests_properties(walkthrough.build PROPERTIES FIXTURES_SETUP web_page
        FIXTURES_REQUIRED "web_module;web_packages" TIMEOUT ${patience})
      foreach(name IN ITEMS page native speed gltf)
        add_test(NAME walkthrough.${name} COMMAND ${SHADOWCUT_NODE} --test
          ${walkthrough}/test/${name}.test.mjs)
        set_tests_properties(walkthrough.${name} PROPERTIES FIXTURES_REQUIRED web_page PROCESSORS 2
          TIMEOUT 1200
          ENVIRONMENT
          "SHADOWCUT_CHROMIUM=${SHADOWCUT_CHROMIUM};SHADOWCUT_PROGRAM=$<TARGET_FILE:shadowcut_cli>")
      endforeach()
    endif()
  endif()
endif()
