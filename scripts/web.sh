#!/usr/bin/env bash
# Installs what is missing, builds the WebAssembly package and the walkthrough, serves it and prints the address.
#   scripts/web.sh            until Ctrl-C
#   scripts/web.sh --build    stops before serving: web/walkthrough/dist can be served from anywhere
source "$(dirname "${BASH_SOURCE[0]}")/setup.sh" emscripten nodejs npm
cmake --preset wasm >/dev/null
cmake --build --preset wasm
cmake -P web/install.cmake
cd web/walkthrough
npm run build
[ "${1:-}" = --build ] && exit
npm run preview -- --port 4173
