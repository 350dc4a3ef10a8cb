# Brings the WebAssembly module up to date: the preset wasm.
execute_process(COMMAND ${CMAKE_COMMAND} --preset wasm COMMAND_ERROR_IS_FATAL ANY)
execute_process(COMMAND ${CMAKE_COMMAND} --build --preset wasm COMMAND_ERROR_IS_FATAL ANY)
