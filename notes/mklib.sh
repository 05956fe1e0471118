#!/bin/bash
set -a
while IFS= read -r l; do export "$l"; done < /work/wt/tmp/diag/env.txt
export CARGO_MANIFEST_DIR=/work/wt/diag
cd /work/wt/diag
mkdir -p /work/wt/tmp/diag/libout /work/wt/tmp/diag/inc
exec rustc --crate-name tumble --edition=2024 src/lib.rs --crate-type lib --emit=${EMIT:-metadata,link} -C opt-level=1 -C codegen-units=64 -C incremental=/work/wt/tmp/diag/inc -A warnings --cfg 'feature="navigate"' --out-dir /work/wt/tmp/diag/libout -L dependency=/work/wt/diag/target/fast/deps \
 --extern calamine=/work/wt/diag/target/fast/deps/libcalamine-ee18b0b911f6de87.rmeta \
 --extern chumsky=/work/wt/diag/target/fast/deps/libchumsky-a0d9424897a0e5ab.rmeta \
 --extern clap=/work/wt/diag/target/fast/deps/libclap-c20e72653faeae9d.rmeta \
 --extern clap_complete=/work/wt/diag/target/fast/deps/libclap_complete-3fdcaa74f0bd1743.rmeta \
 --extern clap_mangen=/work/wt/diag/target/fast/deps/libclap_mangen-e94860e9ec41c1f9.rmeta \
 --extern clarabel=/work/wt/diag/target/fast/deps/libclarabel-41887cf9af7af685.rlib \
 --extern comfy_table=/work/wt/diag/target/fast/deps/libcomfy_table-070bdbf8b85f32ef.rmeta \
 --extern csv=/work/wt/diag/target/fast/deps/libcsv-7561c0d880922532.rmeta \
 --extern faer=/work/wt/diag/target/fast/deps/libfaer-9416b15943dd704a.rmeta \
 --extern flate2=/work/wt/diag/target/fast/deps/libflate2-8ca60d4a221e8be2.rmeta \
 --extern fluent_bundle=/work/wt/diag/target/fast/deps/libfluent_bundle-7ada9b178d5e134b.rmeta \
 --extern hdf5_pure=/work/wt/diag/target/fast/deps/libhdf5_pure-82580b0ec21c9afb.rmeta \
 --extern indicatif=/work/wt/diag/target/fast/deps/libindicatif-ce8b0127b9ed7541.rmeta \
 --extern lz4_flex=/work/wt/diag/target/fast/deps/liblz4_flex-30ad5ca681e28c2a.rmeta \
 --extern miette=/work/wt/diag/target/fast/deps/libmiette-d87727cb907039d2.rmeta \
 --extern minijinja=/work/wt/diag/target/fast/deps/libminijinja-97d5ecdb7111cde8.rmeta \
 --extern nalgebra=/work/wt/diag/target/fast/deps/libnalgebra-25a0ff77031aa9e4.rmeta \
 --extern parquet=/work/wt/diag/target/fast/deps/libparquet-1707dce12f072234.rmeta \
 --extern plotters=/work/wt/diag/target/fast/deps/libplotters-c25c50206d15138c.rmeta \
 --extern pulp=/work/wt/diag/target/fast/deps/libpulp-81b4558920775828.rmeta \
 --extern quick_xml=/work/wt/diag/target/fast/deps/libquick_xml-93290e33a7330076.rmeta \
 --extern rand_distr=/work/wt/diag/target/fast/deps/librand_distr-4b6e6e6b9352aa18.rmeta \
 --extern rand_pcg=/work/wt/diag/target/fast/deps/librand_pcg-85afe76497a69dee.rmeta \
 --extern rayon=/work/wt/diag/target/fast/deps/librayon-aefa7e048d9156f7.rmeta \
 --extern schemars=/work/wt/diag/target/fast/deps/libschemars-870a598cb1f0d64b.rmeta \
 --extern serde=/work/wt/diag/target/fast/deps/libserde-7297ef660356f78f.rmeta \
 --extern serde_json=/work/wt/diag/target/fast/deps/libserde_json-8db1b4b714de0f47.rmeta \
 --extern serde_path_to_error=/work/wt/diag/target/fast/deps/libserde_path_to_error-19c9c0f1213e4954.rmeta \
 --extern sha2=/work/wt/diag/target/fast/deps/libsha2-9c04fd0936669b17.rmeta \
 --extern signal_hook=/work/wt/diag/target/fast/deps/libsignal_hook-081cf68195f33390.rmeta \
 --extern zstd=/work/wt/diag/target/fast/deps/libzstd-be431efa741a0e09.rmeta \
 "$@"
