#!/usr/bin/env bash
# Build the compiled extension into the checkout.
set -euo pipefail
cd "$(dirname "$0")/.."
cargo build --release --manifest-path rust/Cargo.toml
# A process that has the old one mapped keeps it.
cp "${CARGO_TARGET_DIR:-rust/target}/release/lib_native.so" patterndb/_native.new
mv patterndb/_native.new patterndb/_native.abi3.so
