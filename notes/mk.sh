#!/bin/bash
cd /work/wt/diag; D=target/fast/deps
ext() { ls -t $D/lib$1-*.rlib | head -1; }
exec rustc --crate-name lab --edition=2024 examples/lab/main.rs -o /work/wt/tmp/diag/bin/lab -C opt-level=3 -C codegen-units=8 -C link-arg=-fuse-ld=mold -A warnings \
 --extern tumble=${TUMBLE:-/work/wt/tmp/diag/bin/old/libtumble-902880c4e8949ad0.rlib} --extern faer=$(ext faer) --extern rand_distr=$(ext rand_distr) --extern rand_pcg=$(ext rand_pcg) --extern rayon=$(ext rayon) -L dependency=$D "$@"
