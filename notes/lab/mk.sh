cp /work/wt/score/src/diagnosis/score.rs score.rs.new
python3 - <<'P'
s=open('score.rs.new').read().replace('pub','pub')
open('score.rs','w').write(s)
P
F=$(ls -t /work/wt/score/target/fast/deps/libfaer-*.rlib | head -1)
nice rustc --edition 2024 -C opt-level=1 --crate-name h -L dependency=/work/wt/score/target/fast/deps --extern faer=$F main.rs -o h 2>&1 | grep -E "^error" -A6 | head -30
