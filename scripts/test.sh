#!/usr/bin/env bash
# Installs what is missing, builds, and runs every test.
#   scripts/test.sh           the whole suite
#   scripts/test.sh --long    and the soaks: sanitizers, and each fuzzer for ten minutes
source "$(dirname "${BASH_SOURCE[0]}")/setup.sh" libgtest-dev libbenchmark-dev libcgal-dev assimp-testmodels glmark2-data clang libclang-rt-14-dev python3
long=${1:-}
cmake --preset release >/dev/null
cmake --build --preset release
ctest --preset release --timeout 600
