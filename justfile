# Every command that people and CI run.

# Show this list
default:
    @just --list

# Build lodc
build:
    cargo build --release -p lodc

# Format every file
fmt:
    cargo fmt --all

# Formatting, lints, documentation, dependencies
lint:
    .ci/lint

# All tests
test:
    tests/run

# What CI runs
ci:
    .ci/run

# Benchmarks of every stage and every model (three minutes)
bench:
    cargo bench -p lodc --bench pipeline --bench models

# Write the fixture files again
fixtures:
    cargo run --release -p lodc-fixtures --features files --bin generate -- fixtures
