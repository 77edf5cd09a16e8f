#!/usr/bin/env bash
# rerun-sdk 0.22.1 and 0.25.1 (written), 0.41.0 (read), 2026-11-30.
# One would guess: a recording of a version that the newest cannot read is refused with a status that is not 0, or is
# migrated; and what holds for 0.22 and 0.25, both of 2025, is the same.
# What is so: `rerun rrd stats` and `rerun rrd print` of 0.41 end with status 0 on a file of 0.22: stats reports 0
# chunks and 0 entities on standard output, with the reason on standard error alone; `rrd merge` and `rrd migrate` end
# with 1. A file of 0.25 is read.
# Why it matters: recordings of plans and pushes are kept for years, and a script that counts what is in them sees
# empty ones. Keep the version beside a recording, and call `rrd migrate` first: its status can be trusted.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
cat >write.py <<'PYTHON'
import rerun as rr
rr.init("blocks", spawn=False)
rr.save("blocks.rrd")
rr.log("table/block", rr.Points3D([[0, 0, 0], [1, 2, 3]]))
PYTHON
for version in 0.22.1 0.25.1; do
    python3 -m venv "$version"
    "$version/bin/pip" install --quiet --disable-pip-version-check "rerun-sdk==$version" pyarrow==21.0.0 numpy==2.2.6
    (cd "$version" && bin/python ../write.py)
done
python3 -m venv new
new/bin/pip install --quiet --disable-pip-version-check rerun-sdk==0.41.0
export HOME=$folder
for version in 0.22.1 0.25.1; do
    for command in stats print migrate; do
        cp "$version/blocks.rrd" "$version/copy.rrd"
        status=0
        new/bin/rerun rrd "$command" "$version/copy.rrd" >"$version/$command.txt" 2>/dev/null || status=$?
        echo "$status" >"$version/$command.status"
    done
    echo "written by $version, read by 0.41.0: rrd stats has status $(cat "$version/stats.status") and" \
        "$(grep '^num_chunks =' "$version/stats.txt"), rrd print status $(cat "$version/print.status"), rrd migrate status" \
        "$(cat "$version/migrate.status")"
done
[ "$(cat 0.22.1/stats.status 0.22.1/print.status 0.22.1/migrate.status | tr '\n' ' ')" = "0 0 1 " ]
grep -q '^num_chunks = 0$' 0.22.1/stats.txt
! grep -q '^num_chunks = 0$' 0.25.1/stats.txt
