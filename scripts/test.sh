#!/usr/bin/env bash
# Builds, installing missing packages first, and runs every test.
#   scripts/test.sh           all tests, the WebAssembly package in Node, 20 000 runs of each fuzzer
#   scripts/test.sh --web     also the three.js adapter and the walkthrough in a browser (Chromium
#                             has 414 MB)
#   scripts/test.sh --long    also the tests under ASan + UBSan, the tests with several threads
#                             under TSan, and each fuzzer for ten minutes
tools=(libgtest-dev libbenchmark-dev libembree-dev libpolyclipping-dev libcgal-dev
       assimp-testmodels glmark2-data clang libclang-rt-14-dev python3 python3-xlib xvfb emscripten
       nodejs)
budget="-seed=1 -runs=20000"  # the same inputs in every run
presets=(release)
browser=OFF
if [ "${1:-}" = --web ] || [ "${1:-}" = --long ]; then
  browser=ON
  tools+=(npm chromium)
fi
if [ "${1:-}" = --long ]; then
  budget="-max_total_time=600"
  presets=(release asan tsan)
fi
source "$(dirname "${BASH_SOURCE[0]}")/setup.sh" "${tools[@]}"

# The fuzzers need clang.
CXX=clang++ cmake -S . -B build/fuzz -G Ninja -DCMAKE_BUILD_TYPE=RelWithDebInfo \
  -DSHADOWCUT_FUZZ=ON -DSHADOWCUT_BENCH=OFF \
  -DCMAKE_CXX_FLAGS_RELWITHDEBINFO="-O1 -gline-tables-only" \
  -DCMAKE_UNITY_BUILD=ON -DSHADOWCUT_C=OFF -DSHADOWCUT_CLI=OFF -DSHADOWCUT_TESTS=OFF >/dev/null
cmake --build build/fuzz
mkdir -p build/fuzz/corpus/fuzz_obj build/fuzz/corpus/fuzz_build build/fuzz/corpus/fuzz_edits
for name in room1 branch3 tetrahedron2; do
  head -c 4000 "data/$name.obj" >"build/fuzz/corpus/fuzz_obj/$name"
done
fuzz() {
  "build/fuzz/bin/$1" "build/fuzz/corpus/$1" $budget -max_len=4096 -timeout=20 \
    -rss_limit_mb=4096 -artifact_prefix=build/fuzz/ \
    >"build/fuzz/$1.log" 2>&1 || { tail -n 40 "build/fuzz/$1.log"; exit 1; }
  echo "$1: $(tail -n 1 "build/fuzz/$1.log")"
}
export -f fuzz
export budget
echo "fuzzing: $budget"
printf '%s\n' fuzz_obj fuzz_build fuzz_edits | xargs -P "$(nproc)" -I{} bash -c 'fuzz {}'
echo "laws of the exact predicates, compiled by clang"
SHADOWCUT_SOAK=30000 build/fuzz/bin/predicates_clang --gtest_brief=1

for preset in "${presets[@]}"; do
  cmake --preset "$preset" -DSHADOWCUT_TESTS=ON -DSHADOWCUT_WEB=ON \
    -DSHADOWCUT_BROWSER="$browser" >/dev/null
  cmake --build --preset "$preset"
  ctest --preset "$preset" --timeout 1200 -j "$(nproc)"
done
