#!/usr/bin/env bash
# Installs what is missing, builds, and runs every test.
#   scripts/test.sh           the whole suite, and each fuzzer for some seconds
#   scripts/test.sh --long    the suite under ASan + UBSan and under TSan too, and each fuzzer for ten minutes
source "$(dirname "${BASH_SOURCE[0]}")/setup.sh" libgtest-dev libbenchmark-dev libcgal-dev assimp-testmodels glmark2-data clang libclang-rt-14-dev python3
seconds=20
presets=(release)
if [ "${1:-}" = --long ]; then
  seconds=600
  presets=(release asan tsan)
fi

for preset in "${presets[@]}"; do
  cmake --preset "$preset" -DSHADOWCUT_TESTS=ON >/dev/null
  cmake --build --preset "$preset"
  ctest --preset "$preset" --timeout 1200
done

# The fuzzers need clang. They start from the shipped scenes and must find nothing.
CXX=clang++ cmake -S . -B build/fuzz -G Ninja -DCMAKE_BUILD_TYPE=RelWithDebInfo -DSHADOWCUT_FUZZ=ON -DSHADOWCUT_BENCH=OFF \
  -DSHADOWCUT_CLI=OFF -DSHADOWCUT_TESTS=OFF >/dev/null
cmake --build build/fuzz
for fuzzer in build/fuzz/bin/fuzz_*; do
  corpus=build/fuzz/corpus/$(basename "$fuzzer")
  mkdir -p "$corpus"
  "$fuzzer" "$corpus" -max_total_time="$seconds" -timeout=20 -rss_limit_mb=4096 -print_final_stats=1 2>&1 | tail -n 5
done
