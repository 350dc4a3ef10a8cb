#!/usr/bin/env bash
# Installs what is missing, builds, casts the shadows of a furnished room and draws them; then carries a computer across the room, and at last
# draws the room with OpenGL, by the engine's fragments.
source "$(dirname "${BASH_SOURCE[0]}")/setup.sh" librsvg2-bin
cmake --preset release -DSHADOWCUT_TESTS=OFF -DSHADOWCUT_BENCH=OFF >/dev/null
cmake --build --preset release --target shadowcut_cli
mkdir -p out
build/release/bin/shadowcut cast data/room4.obj --light point:5.3613,3.7171,2.43 --svg 0.3,0.3,2.5,6,5,0.2,75 \
  -o out/room.svg -o out/room.glb --areas out/room.csv --json out/room.json "$@"
rsvg-convert out/room.svg -o out/room.png
# The tree after every step is held against a rebuild; the times are of the updates alone.
echo
build/release/bin/shadowcut replay data/room4.obj data/room4_edits.jsonl --light point:5.3613,3.7171,2.43 --verify --json out/moves.json >/dev/null
build/release/bin/shadowcut replay data/room4.obj data/room4_edits.jsonl --light point:5.3613,3.7171,2.43 --changes out/moves.jsonl
echo
build/release/bin/shadowcut render data/room4.obj --light point:5.3613,3.7171,2.43 --technique fragments --camera 0.3,0.3,2.5,6,5,0.2,75 \
  --size 1024x768 -o out/room_fragments.png
echo "drawn: out/room_fragments.png by OpenGL, out/room.svg and out/room.png without; fragments: out/room.glb; areas of every face: out/room.csv"
echo "moves: out/moves.json, each verified; what each changed: out/moves.jsonl"
