# Every command that people and CI run.

# Show this list
default:
    @just --list

# Build lodc
build:
    cargo build --release --bin lodc

# Format every file
fmt:
    cargo fmt --all

# Formatting, lints, documentation, dependencies
lint:
    .ci/lint

# Tests that need nothing from outside; --all: every test
test *words:
    tests/run {{words}}

# What CI runs
ci:
    .ci/run

# Benchmarks of every stage and every model (three minutes)
bench:
    cargo bench -p lodc-lab --features bench --bench pipeline --bench models

# Four models of the corpus (folder: LODC_CORPUS) at 5 % by two metrics: contact sheets, distances and image errors in target/study
study: build
    #!/usr/bin/env bash
    set -euo pipefail
    mkdir -p target/study
    for model in gltf/bevy/FlightHelmet/FlightHelmet.gltf gltf/khronos/DamagedHelmet/DamagedHelmet.gltf \
        gltf/khronos/2CylinderEngine.glb ugly/fordFocus.obj; do
        for metric in quadric hybrid; do
            out="target/study/$(basename "${model%.*}").$metric"
            target/release/lodc build "$LODC_CORPUS/$model" -o "$out.lodc" --metric "$metric" --models interactive -q
            target/release/lodc render "$out.lodc" -o "$out.png" --contact-sheet 1,0.05
            target/release/lodc extract "$out.lodc" --ratio 0.05 -o "$out.glb" -q
            target/release/lodc compare -q "$LODC_CORPUS/$model" "$out.glb" | tee "$out.txt"
        done
    done

# Write the fixture files again
fixtures:
    cargo run --release -p lodc-fixtures --features files --bin generate -- fixtures

# Write the answers of the README's tour anew
tour:
    UPDATE=1 cargo test -p lodc-cli --test cli readme

# Write docs/OPTIONS.md anew
options:
    UPDATE=1 cargo test -p lodc-cli --bin lodc page

# Draw the pictures of README and CLI.md again (docs/*.png)
picture: build
    cargo run --release -p lodc-fixtures --example shell -- target/shell.obj
    target/release/lodc render target/shell.obj --contact-sheet 1,0.1,0.03,0.01 --size 320x380 \
        --shading flat --wireframe --azimuth 20 --elevation 12 -o docs/levels.png
    target/release/lodc render target/shell.obj --contact-sheet 1,0.5,0.25,0.1 --size 240x240 --shading flat \
        --wireframe --criterion silhouette --coarse 5% --eye 1.8,1.6,5 --fovy 31 -o docs/views.png
    target/release/lodc render target/shell.obj --size 300x300 --shading flat --wireframe --criterion box \
        --box -9,-9,-9,0.15,9,9 --azimuth 20 --elevation 12 -o docs/half-refined.png
    python3 docs/geomorph.py target/release/lodc target/shell.obj docs/geomorph.png
    awk '/^v / { print $1, $2, $3, $4, ($3 > 0.75 ? "1 0.6 0.4" : "0.3 0.6 0.7"); next } 1' target/shell.obj > target/painted.obj
    target/release/lodc build target/painted.obj --importance COLOR_0 --weight color=0 --models none -o target/painted.lodc
    target/release/lodc render target/painted.lodc --contact-sheet 0.25,0.1,0.03 --size 240x240 --shading flat \
        --wireframe --azimuth 20 --elevation 12 -o docs/painted.png

# Draw the picture of the packages again (docs/packages.svg)
drawing:
    UPDATE=1 cargo test -p lodc-fixtures --test architecture picture

# Build the browser package, and serve its example on port 8000: http://localhost:8000/example/
web: build
    #!/usr/bin/env bash
    set -euo pipefail
    crates/web/build
    (cd target/web && npm install --silent --no-audit --no-fund --no-save three@0.180.0)
    mkdir -p target/web/models
    target/release/lodc build fixtures/machine_part.glb -o target/web/models/crowd.lodc -q
    target/release/lodc build fixtures/terrain.glb -o target/web/models/terrain.lodc -q
    target/release/lodc pack target/web/models/terrain.lodc -o target/web/models/stream.lods -q
    target/release/lodc build fixtures/terrain.glb --layout gpu -o target/web/models/gpu.lodc -q
    target/release/lodc shaders -o target/web/shaders -q
    target/release/lodc chain fixtures/terrain.glb -o target/web/models/chain.glb --auto 5 --geomorph -q
    python3 -m http.server 8000 --directory target/web

# Measure how long the page's thread is busy at a stretch while a large model opens in a browser
web-long-tasks *triangles: build
    #!/usr/bin/env bash
    set -euo pipefail
    crates/web/build
    (cd target/web && npm install --silent --no-audit --no-fund --no-save three@0.180.0)
    LODC="$PWD/target/release/lodc" LODC_WEB="$PWD/target/web" node crates/web/test/longtasks.mjs {{triangles}}

# The bars on lodc's time beside gltfpack and others; with a mesh how close levels are; --build-openmesh adds OpenMesh
other-tools *words:
    tests/other_tools/run {{words}}

# Levels beside those of other tools on a folder of models, in pictures, outlines and distances: FOLDER [--ratios R,R] [--ways W,W] [--models NAME,NAME] [--rows FILE]
league folder *words: build
    tests/league/run {{folder}} {{words}}

# Draw the plots of docs/BENCHMARKS.md from docs/benchmarks/*.csv
plots:
    python3 tests/plots.py

# How counted work grows with each count that a file can hold (by valgrind, ten minutes): at most 2.4 times for twice the count. --time: how time does, at larger counts
growth *words: build
    python3 tests/growth.py target/release/lodc {{words}}

# Kills, faults of system calls, determinism, clean files, what levels of many kinds of meshes state, with figures; then more mutated meshes through build and verify
campaign *words: build numpy
    LODC_PYTHON=target/numpy/bin/python python3 tests/campaign.py target/release/lodc {{words}}
    LODC_MUTATIONS=5000 cargo test --release -p lodc-report --test mutated

# Builds, verifies, extracts and streams the largest meshes of the corpus (folder: LODC_CORPUS)
corpus:
    cargo test --release -p lodc-cli --test cli -- --ignored every_large_mesh

# What levels state beside a second evaluator, for some kinds and sizes of meshes: [--kinds A,B] [--sizes N,N] [--ways W,W] [--seed N] [--csv FILE]
kinds *words: build numpy
    target/numpy/bin/python tests/kinds target/release/lodc {{words}}

# Errors of levels of generated faces, props and rigs in motion, beside bars: [--before PROGRAM] [--seed N] [--only A,B] [--csv FILE]
motion *words: build
    python3 tests/motion.py target/release/lodc {{words}}

[private]
numpy:
    [ -x target/numpy/bin/python ] || python3 -m venv target/numpy
    target/numpy/bin/python -m pip install --quiet --disable-pip-version-check numpy==2.2.1

# Coverage-guided fuzzing of the readers, and of build and verify; runs and finds of each target: [--minutes N | --runs N] [TARGET...]
fuzz *words:
    python3 formats/fuzz/run.py {{words}}
