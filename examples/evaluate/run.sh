#!/usr/bin/env bash
# Every kind of experiment on a virtual mat: makes recordings and tables of trials as a person at a mat would, and evaluates
# them by plan.toml. A few seconds.
#
#   examples/evaluate/run.sh [FOLDER]      TAXEL: the command (default: what was built here, then `taxel` on the path)
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
cp "$here/plan.toml" "$here/sensor.toml" "$folder"
cd "$folder"

# The mat at hand: its row switches have 11 Ohm, its file says 10. And the file of the same mat at another test voltage.
sed 's/r_mux_row_ohms = 10.0/r_mux_row_ohms = 11.0/' sensor.toml >real.toml
sed 's/v_test_volts = 0.4/v_test_volts = 1.0/' sensor.toml >sensor-1v.toml
sed 's/v_test_volts = 0.4/v_test_volts = 1.0/' real.toml >real-1v.toml

# 1. Repeatability: 100 g everywhere, three times set up. Before, the reading at row 3, column 4 is lost in one frame of five to seven.
echo recording,row,column,setting,experiment >repeatability.csv
for turn in 1 2 3; do
    "$TAXEL" simulate --sensor real.toml --pattern uniform --load-g 100 --frames 30 --seed $turn -o after-$turn.txt
    awk -F, -v OFS=, -v turn=$turn 'NR % (32 + 8 * turn) == 4 { $5 = 0 } 1' after-$turn.txt >before-$turn.txt
    for setting in before after; do
        echo "$setting-$turn.txt,3,4,$setting,$setting $turn" >>repeatability.csv
    done
done

# 2. Response: six loads, five frames each, set up three times, at two test voltages.
echo recording,frame,load_g,row,column,setting,experiment >response.csv
for turn in 1 2 3; do
    for volts in 0.4 1; do
        sensor=real.toml
        [ $volts = 1 ] && sensor=real-1v.toml
        "$TAXEL" simulate --sensor $sensor --pattern uniform --load-g 25,50,100,200,400,600 --frames 30 \
            --seed 1$turn -o response-$volts-$turn.txt --presses uniform.csv
        tail -n +2 uniform.csv | awk -v end=",2,2,$volts V,$turn" '{ print $0 end }' >>response.csv
    done
done

# 3. to 5. One taxel whose conductance is given, the others at rest: R lines of C siemens a frame.
taxels() { # of lines `frame-th conductance, how many of the row`, what the read-out gives
    awk '{ for (r = 0; r < 8; r++) { line = ""
             for (c = 0; c < 8; c++) line = line (c ? "," : "") (r == 2 && c < $2 ? $1 : 1e-6)
             print line } }' >siemens.csv
    "$TAXEL" simulate --sensor real.toml --conductance siemens.csv --unit counts -o "$1"
}
# Loops: up and down over five loads; on the way down 6 % of the conductance stay.
echo recording,frame,row,column,load_g,experiment >loops.csv
for turn in 1 2 3; do
    awk -v turn=$turn 'BEGIN {
        n = split("0 50 100 150 200 150 100 50 0", load, " ")
        for (i = 1; i <= n; i++) {
            stay = i > 5 ? 1 + 0.06 * (1 + 0.1 * turn) * (1 - load[i] / 200) : 1
            print (1e-6 + 8.29e-6 * (load[i] + 5) ^ 0.857) * stay, 1
            printf "loop-%d.txt,%d,2,0,%d,loop %d\n", turn, i - 1, load[i], turn >>"loops.csv"
        }
    }' | taxels loop-$turn.txt
done
# Holds: the conductance grows by 8 % with a time constant of 20 s. A line of the table without a frame is all frames.
echo recording,row,column,load_g >creep.csv
for turn in 1 2 3; do
    awk -v turn=$turn 'BEGIN { for (i = 0; i < 360; i++)
        print 8e-4 * (1 + (0.07 + 0.005 * turn) * (1 - exp(-i / 2 / 20))), 1 }' | taxels hold-$turn.txt
    echo "hold-$turn.txt,2,0,200" >>creep.csv
done
# Cross-talk: taxel 2,0 with 7, 6, ... 0 others of its row.
echo recording,frame,row,column,others,experiment >row.csv
for turn in 1 2 3; do
    awk -v turn=$turn 'BEGIN { for (n = 7; n >= 0; n--) {
        print 1e-3 + turn * 2e-5, n + 1
        printf "row-%d.txt,%d,2,0,%d,area %d\n", turn, 7 - n, n, turn >>"row.csv"
    } }' | taxels row-$turn.txt
done

# 6. and 7. Accuracy: one taxel alone in each of 40 frames, and 12 frames whose loads are all known.
"$TAXEL" simulate --sensor real.toml --pattern press --frames 40 --seed 21 -o presses.txt --presses presses.csv
"$TAXEL" simulate --sensor real.toml --pattern blobs --frames 12 --seed 22 -o frames.txt --truth frames-load-g.csv

"$TAXEL" evaluate plan.toml -o report.html
echo "files in $folder"
