#!/bin/bash
cd /work/wt/diag; D=target/fast/deps
ext() { ls -t $D/lib$1-*.rlib $D/lib$1-*.so 2>/dev/null | head -1; }
E=""
for c in faer rand_distr rand_pcg rayon serde_json approx insta tempfile; do f=$(ext $c); [ -n "$f" ] && E="$E --extern $c=$f"; done
set -a; while IFS= read -r l; do export "$l"; done < /work/wt/tmp/diag/env.txt; export CARGO_MANIFEST_DIR=/work/wt/diag CARGO_TARGET_TMPDIR=/work/wt/tmp/diag
exec rustc --test --crate-name diagnosis_tests --edition=2024 tests/diagnosis/part.rs -o /work/wt/tmp/diag/bin/tests -C opt-level=1 -C codegen-units=16 -C link-arg=-fuse-ld=mold -A warnings --cfg 'feature="navigate"' --extern tumble=/work/wt/tmp/diag/libout/libtumble.rlib $E -L dependency=$D
