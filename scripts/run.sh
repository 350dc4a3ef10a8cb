#!/usr/bin/env bash
# Builds the program, installing missing packages first. Then casts the shadows of a furnished room,
# replays moves of a computer through the room, and draws the room with OpenGL. Writes into out/.
source "$(dirname "${BASH_SOURCE[0]}")/setup.sh" librsvg2-bin
cmake --preset release -DSHADOWCUT_TESTS=OFF -DSHADOWCUT_BENCH=OFF >/dev/null
cmake --build --preset release --target shadowcut_cli
mkdir -p out
shadowcut=build/release/bin/shadowcut
room=(data/room4.obj --light point:5.3613,3.7171,2.43)
moves=(data/room4.obj data/room4_edits.jsonl --light point:5.3613,3.7171,2.43)
camera=0.3,0.3,2.5,6,5,0.2,75

"$shadowcut" cast "${room[@]}" --svg "$camera" -o out/room.svg -o out/room.glb \
  --areas out/room.csv --json out/room.json "$@"
rsvg-convert out/room.svg -o out/room.png
echo
# Twice: --verify compares every update with a rebuild, and the second run measures without it.
"$shadowcut" replay "${moves[@]}" --verify --json out/moves.json >/dev/null
"$shadowcut" replay "${moves[@]}" --changes out/moves.jsonl
echo
"$shadowcut" render "${room[@]}" --technique fragments --camera "$camera" --size 1024x768 \
  -o out/room_fragments.png
echo "pictures: out/room_fragments.png (OpenGL), out/room.svg and out/room.png (exact)"
echo "fragments: out/room.glb; areas of every face: out/room.csv"
echo "verified updates: out/moves.json; changes of every update: out/moves.jsonl"
