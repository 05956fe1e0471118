#!/bin/bash
# run.sh BINARY ARGS...: run a test binary with the worktree mounted
exec unshare -m bash -c 'mount --bind /work/wt/score /work/wt/base && cd /work/wt/base && exec nice -n 4 "$@"' _ "$@"
