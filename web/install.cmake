# Installs the npm packages here as the lock says, unless they are: cmake -P web/install.cmake
set(web ${CMAKE_CURRENT_LIST_DIR})
set(installed ${web}/node_modules/.package-lock.json)
if(NOT EXISTS ${installed} OR NOT ${installed} IS_NEWER_THAN ${web}/package-lock.json)
  execute_process(COMMAND npm ci --no-audit --no-fund WORKING_DIRECTORY ${web}
    COMMAND_ERROR_IS_FATAL ANY)
endif()
