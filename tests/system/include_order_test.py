"""The folders of src/core are the stages of the pipeline: a folder includes only itself and folders
before it, and no file is longer than 450 lines.

    include_order_test.py SRC/CORE
"""

import pathlib
import re
import sys

# As in src/core/CMakeLists.txt.
STAGES = (
    'support numbers scene light_space predicates clipping facets svbsp fragments engine'.split()
)
MOST_LINES = 450


def problems(core):
    for path in sorted(core.rglob('*.[ch]pp')):
        name = path.relative_to(core)
        lines = path.read_text().splitlines()
        if len(lines) > MOST_LINES:
            yield f'{name}: {len(lines)} lines, more than {MOST_LINES}'
        if len(name.parts) != 2 or name.parts[0] not in STAGES:
            yield f'{name}: not in a folder of a stage'
            continue
        stage = STAGES.index(name.parts[0])
        for number, line in enumerate(lines, 1):
            include = re.match(r'\s*#\s*include\s*"([^"]+)"', line)
            if not include:
                continue
            folder = include[1].split('/')[0]
            if folder not in STAGES or '/' not in include[1]:
                yield f'{name}:{number}: "{include[1]}" does not name a folder of a stage'
            elif STAGES.index(folder) > stage:
                yield f'{name}:{number}: {name.parts[0]} must not include {folder}'


found = list(problems(pathlib.Path(sys.argv[1])))
print('\n'.join(found) or 'every folder includes only itself and folders before it')
sys.exit(1 if found else 0)
