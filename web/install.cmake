# Installs the npm packages of web/ as the lock says, unless they are: -DNPM=, -DWEB=.
set(installed ${WEB}/node_modules/.package-lock.json)
if(NOT EXISTS ${installed} OR NOT ${installed} IS_NEWER_THAN ${WEB}/package-lock.json)
  execute_process(COMMAND ${NPM} ci --no-audit --no-fund WORKING_DIRECTORY ${WEB} COMMAND_ERROR_IS_FATAL ANY)
endif()
