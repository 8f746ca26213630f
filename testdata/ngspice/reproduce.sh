#!/bin/sh
# Runs ngspice on the netlist of every case here and prints, per case, the number of taxels and the largest relative
# difference from v_out.csv; fails when one is above 1e-7. A case without a v_out.csv gets one.
set -eu
here=$(cd "$(dirname "$0")" && pwd)
if ! command -v ngspice >/dev/null; then
    echo "ngspice is not installed: nothing was compared" >&2
    exit 0
fi
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
(cd "$here/../.." && cargo run --quiet -p taxel --example ngspice_golden -- "$work")
status=0
for netlist in "$work"/*.cir; do
    name=$(basename "$netlist" .cir)
    answers="$here/$name/v_out.csv"
    ngspice -b "$netlist" 2>/dev/null |
        awk 'BEGIN { print "row,column,v_out_volts" } $1 == "taxel" { print $2 "," $3 "," $NF }' >"$work/found.csv"
    if [ ! -e "$answers" ]; then
        cp "$work/found.csv" "$answers"
        echo "$name: v_out.csv written"
        continue
    fi
    awk -F, -v name="$name" '
        FNR == 1 { next }
        NR == FNR { kept[$1 "," $2] = $3; wanted++; next }
        { difference = ($3 - kept[$1 "," $2]) / kept[$1 "," $2]; if (difference < 0) difference = -difference
          if (difference > largest) largest = difference; found++ }
        END { printf "%-42s %4d taxels %8.1e\n", name, found, largest; exit !(found == wanted && largest < 1e-7) }
    ' "$answers" "$work/found.csv" || status=1
done
exit $status
