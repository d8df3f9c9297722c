#!/usr/bin/env bash
# Changes the program line by line and looks whether a test sees it: tests/mutants.sh [SHARD, such as 3/40] [options of cargo mutants].
# Needs cargo-mutants (cargo install cargo-mutants). What was missed is in target/mutants/mutants.out/missed.txt.
set -euo pipefail
cd "$(dirname "$0")/.."
shard=${1:-0/1}
shift || true
cargo mutants --version >/dev/null || { echo "cargo-mutants is not installed: cargo install cargo-mutants" >&2; exit 2; }
exec cargo mutants --output target/mutants --shard "$shard" --sharding round-robin --timeout 600 \
    --file 'src/diagnosis/**' --file 'src/model/**' --file 'src/recording/**' "$@" \
    -- --lib -- diagnosis:: model:: recording::
