#!/bin/bash
# every worktree below /work/wt is seen at /work/wt/base while cargo runs, so that copied build products are used again;
# at most two of them compile at a time (running tests does not count)
real=/work/wt/.bin/cargo
here=$(pwd -P)
slot() { # wait for one of two slots, kept on descriptor 9
  [ -n "${TUMBLE_SLOT-}" ] && return
  export TUMBLE_SLOT=1
  while true; do
    for s in $slots; do exec 9>/work/wt/.bin/slot$s; flock -n 9 && return; done
    sleep 0.7
  done
}
case "$here" in
  /work/wt/base|/work/wt/base/*|/work/wt/tmp|/work/wt/tmp/*) exec $real "$@";;
  /work/wt/*/*|/work/wt/*)
    rel=${here#/work/wt/}; name=${rel%%/*}; rest=${rel#"$name"}
    [ -e "/work/wt/$name/Cargo.toml" ] || exec $real "$@"
    case "$name" in all|main) ;; *) case "${1-}" in build|check|clippy|test|doc|rustc)
      echo "cargo is closed here since 21:00 UTC: the coordinator has merged all branches (numbers, export, report, program, reader, noise as committed) into the branch 'all' (/work/wt/all) and builds and tests that alone. Do not build, rebase or land any more. If you know of a failing test or a needed correction, commit it on your branch as a small commit on top and name it in your report. Write your report now (it is your last message)." >&2; exit 1;; esac;; esac
    case "$name" in reader|diag|noise) slots=1; export TUMBLE_NICE=19;; *) slots="2 1"; export TUMBLE_NICE=3;; esac
    run() { unshare -m bash -c 'mount --bind "$1" /work/wt/base && cd "/work/wt/base$2" && shift 2 && exec nice -n $TUMBLE_NICE '"$real"' "$@"' _ "/work/wt/$name" "$rest" "$@"; }
    case "${1-}" in build|check) # the unit tests of the library would compile it a second time
      args=(); for a in "$@"; do if [ "$a" = --tests ]; then args+=(--lib --bins --test '*'); else args+=("$a"); fi; done; set -- "${args[@]}";; esac
    case "${1-}" in
      build|check|clippy|doc|rustc) slot; run "$@"; exit $?;;
      test)
        before=(); for a in "$@"; do [ "$a" = -- ] && break; before+=("$a"); done
        case " $* " in *" --no-run "*) slot; run "$@"; exit $?;; esac
        ( slot; run "${before[@]}" --no-run ) || exit $?
        run "$@"; exit $?;;
      *) run "$@"; exit $?;;
    esac;;
esac
exec $real "$@"
