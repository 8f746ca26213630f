#!/usr/bin/env bash
# The main job on files: a virtual e-Cone that differs from its parts list is calibrated from labelled presses and
# uniform loads, and judged on frames that the calibration never saw.
#
#   examples/econe/run.sh [FOLDER]      TAXEL: the command (default: what was built here, then `taxel` on the path)
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
folder=${1:-$(mktemp -d)}
if [ -z "${TAXEL:-}" ]; then
    TAXEL=taxel
    for built in debug release; do
        [ -x "$here/../../target/$built/taxel" ] && TAXEL=$here/../../target/$built/taxel
    done
fi
mkdir -p "$folder"
cd "$folder"

# The sensor at hand: every switch and taxel differs by a tenth, one row is dead, one column flickers, 0.2 % of the
# readings are stuck. Same seed, same sensor.
real="--sensor econe --imperfect uneven --seed 7"

# 1. What you would record with a force gauge and a bladder.
"$TAXEL" simulate $real --pattern press --frames 120 --presses experiments.csv -o presses.txt
"$TAXEL" simulate $real --pattern uniform --load-g 50,150,400 --frames 12 --presses equilibration.csv -o uniform.txt

# 2. The parts list, the presses, the uniform loads: a calibrated sensor.
"$TAXEL" calibrate --sensor "$here/../../crates/taxel/examples/econe-parts.toml" --presses experiments.csv --equilibration equilibration.csv \
    -o calibrated.toml | tee report.txt

# 3. Frames that it is judged on.
"$TAXEL" simulate $real --pattern blobs --frames 12 --truth truth.csv -o validation.txt

# 4. Loads: with the circuit undone, and with the load law alone.
"$TAXEL" compensate validation.txt --sensor calibrated.toml --unit g -o loads.csv
"$TAXEL" compensate validation.txt --sensor calibrated.toml --unit g --method raw -o raw.csv
"$TAXEL" plot validation.txt --sensor calibrated.toml --frame 0 -o before-after.png

# 5. Against the truth. A mark of 0 is a good taxel; dead, flickering, stuck and repaired ones are left out.
error() {
    paste -d' ' <(tr -s ',' '\n' <truth.csv | sed '/^$/d') <(tr -s ',' '\n' <"$1" | sed '/^$/d') \
        <(tr -s ',' '\n' <"${1%.csv}.marks.csv" | sed '/^$/d') |
        awk -v name="$2" '
            { all++ }
            $3 == 0 {
                good++
                e = $2 - $1; if (e < 0) e = -e
                if ($1 > 0) { loaded++; sum += e } else if (e > ghost) ghost = e
            }
            END {
                printf "%-28s %8.3f g mean absolute error over %d loaded taxels, largest ghost %.3f g (%d of %d taxels judged)\n",
                    name, sum / loaded, loaded, ghost, good, all
            }'
}

# 6. A person grips it: force over time, in all, as an instrumented cylinder reads it, of palm, thumb and fingers.
"$TAXEL" simulate $real --pattern grip --frames 950 -o grip.txt
"$TAXEL" measure grip.txt --sensor calibrated.toml --frames-per-second 100 --regions auto --repair -o force.csv --picture force.png

echo
error raw.csv "the load law alone"
error loads.csv "the circuit undone"
echo "files in $folder"
