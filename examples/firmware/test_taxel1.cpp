// Writes three known frames to standard output, as the sketch would send them: what
// crates/taxel-acquire/testdata/arduino-16x16.bin holds. Fails when the clock does not go on across its wrap.
// SPDX-License-Identifier: MIT OR Apache-2.0
#include <stdio.h>

#include "mat_16x16/taxel1.h"

static bool clock_goes_on() {
  taxel1::LongClock clock;
  const uint64_t wrap = uint64_t(1) << 32;
  return clock.extend(0xFFFFFFF0UL) == 0xFFFFFFF0UL && clock.extend(4) == wrap + 4 && clock.extend(4) == wrap + 4 &&
         clock.extend(0xFFFFFFFFUL) == wrap + 0xFFFFFFFFUL && clock.extend(0) == 2 * wrap;
}

int main() {
  if (!clock_goes_on()) {
    fputs("the clock does not go on across its wrap\n", stderr);
    return 1;
  }
  taxel1::Packet<16, 16, 10> packet;
  for (uint32_t number = 0; number < 3; number++) {
    // Column by column, as the sketch scans.
    for (uint16_t column = 0; column < 16; column++) {
      for (uint16_t row = 0; row < 16; row++) {
        const uint32_t taxel = row * 16u + column;
        packet.set(row, column, uint16_t((37 * taxel + 101 * number) % 1024));
      }
    }
    packet.send(7, number, 10000 * uint64_t(number), [](uint8_t byte) { putchar(byte); });
  }
  return fflush(stdout) == 0 ? 0 : 1;
}
