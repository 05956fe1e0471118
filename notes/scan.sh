#!/bin/bash
# seed each settings...
B=/work/wt/tmp/diag/bin/lab
for o in "outside=0.01 odds=0.01 rank=4" "outside=0.01 odds=0.03 rank=4" "outside=0.003 odds=0.03 rank=3" "outside=0.003 odds=0.01 rank=4"; do
 echo "== $o"; for m in three outside mixed none; do $B 16 7000000 $m $o | grep -A3 "^mode" | tail -2; done; done
