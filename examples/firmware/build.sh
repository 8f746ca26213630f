#!/usr/bin/env bash
# Compares the encoder's bytes with crates/taxel-acquire/testdata/arduino-16x16.bin and builds the sketch without the Arduino IDE.
#
#   examples/firmware/build.sh [FOLDER]     FOLDER gets mat_16x16.elf and .hex (default: a temporary one)
#
# Debian's packages: g++ gcc-avr avr-libc arduino-core-avr. ARDUINO_AVR names another folder of Arduino's AVR core.
# Without them nothing is built and nothing fails, unless the variable CI is set.
set -euo pipefail
here=$(cd "$(dirname "$0")" && pwd)
core=${ARDUINO_AVR:-/usr/share/arduino/hardware/arduino/avr}
# Of 2048 bytes; the rest is for the stack.
most_ram=1536

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
out=${1:-$work}
mkdir -p "$out"

absent() {
    echo "$1 not found: $2 (apt-get install g++ gcc-avr avr-libc arduino-core-avr)" >&2
    [ -z "${CI:-}" ] || exit 1
    exit 0
}

command -v g++ >/dev/null || absent g++ "nothing was checked"
g++ -std=c++11 -O1 -Wall -Wextra -Wconversion -Werror -fsanitize=address,undefined -o "$work/test" \
    "$here/test_taxel1.cpp"
"$work/test" >"$work/frames.bin"
if ! cmp "$work/frames.bin" "$here/../../crates/taxel-acquire/testdata/arduino-16x16.bin"; then
    echo "the encoder's bytes are not those of crates/taxel-acquire/testdata/arduino-16x16.bin" >&2
    exit 1
fi
echo "encoder: $(wc -c <"$work/frames.bin") bytes, as in crates/taxel-acquire/testdata/arduino-16x16.bin"

for tool in avr-gcc avr-g++ avr-gcc-ar avr-objcopy avr-size; do
    command -v "$tool" >/dev/null || absent "$tool" "the sketch was not built"
done
[ -e "$core/cores/arduino/Arduino.h" ] || absent "$core/cores/arduino/Arduino.h" "the sketch was not built"

# As Arduino's own platform.txt and boards.txt do for an Uno, with warnings for the sketch alone.
common=(-mmcu=atmega328p -DF_CPU=16000000L -DARDUINO=10819 -DARDUINO_AVR_UNO -DARDUINO_ARCH_AVR
    -Os -g -ffunction-sections -fdata-sections -flto
    -I "$core/cores/arduino" -I "$core/variants/standard")
c=(avr-gcc "${common[@]}" -fno-fat-lto-objects -std=gnu11 -w -c)
# Debian's avr-g++ 5 has no DECIMAL_DIG in C++, which the core's strings need.
cpp=(avr-g++ "${common[@]}" -std=gnu++11 -fpermissive -fno-exceptions -fno-threadsafe-statics
    -DDECIMAL_DIG=__DECIMAL_DIG__ -c)

mkdir "$work/core"
for source in "$core"/cores/arduino/*.c "$core"/cores/arduino/*.S "$core"/cores/arduino/*.cpp; do
    object=$work/core/$(basename "$source").o
    case $source in
        *.cpp) "${cpp[@]}" -w -o "$object" "$source" ;;
        *.S) "${c[@]}" -x assembler-with-cpp -o "$object" "$source" ;;
        *) "${c[@]}" -o "$object" "$source" ;;
    esac
done
avr-gcc-ar rcs "$work/core.a" "$work"/core/*.o
"${cpp[@]}" -Wall -Wextra -Werror -x c++ -include Arduino.h -o "$work/sketch.o" "$here/mat_16x16/mat_16x16.ino"
avr-gcc -mmcu=atmega328p -Os -g -flto -fuse-linker-plugin -Wl,--gc-sections \
    -o "$out/mat_16x16.elf" "$work/sketch.o" "$work/core.a" -lm
avr-objcopy -O ihex -R .eeprom "$out/mat_16x16.elf" "$out/mat_16x16.hex"

# avr-size: text, data, bss. What data begins with lies in flash too.
read -r text data bss _ < <(avr-size "$out/mat_16x16.elf" | tail -n 1)
flash=$((text + data))
ram=$((data + bss))
echo "sketch: $flash of 32256 bytes of flash, $ram of 2048 bytes of RAM"
if [ "$ram" -gt "$most_ram" ]; then
    echo "more than $most_ram bytes of RAM: too little is left for the stack" >&2
    exit 1
fi
