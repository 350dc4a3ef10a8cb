# Installs the npm packages of web/ as the lock says, unless they are: -DNPM=, -DWEB=.
if(NOT ${WEB}/node_modules/.package-lock.json IS_NEWER_THAN ${WEB}/package-lock.json)
  execute_process(COMMAND ${NPM} ci --no-audit --no-fund WORKING_DIRECTORY ${WEB} COMMAND_ERROR_IS_FATAL ANY)
endif()
