#!/usr/bin/env bash
# Builds the WebAssembly package and the walkthrough, installing missing packages first.
#   scripts/web.sh            serves the walkthrough until Ctrl-C and prints its address
#   scripts/web.sh --build    only builds; any server can serve web/walkthrough/dist
source "$(dirname "${BASH_SOURCE[0]}")/setup.sh" emscripten nodejs npm
cmake --preset wasm >/dev/null
cmake --build --preset wasm
cmake -P web/install.cmake
cd web/walkthrough
npm run build
[ "${1:-}" = --build ] && exit
npm run preview -- --port 4173
