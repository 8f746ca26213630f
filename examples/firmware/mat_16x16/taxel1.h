// Packets of `taxel-1`, the binary protocol that `taxel` reads: one frame each, COBS between zero bytes.
//
//   at    bytes   what (little-endian)
//   0     1       version, 1
//   1     1       bits a count: 8, 10, 12 or 16
//   2     2       sensor id
//   4     4       sequence number
//   8     8       device time, microseconds
//   16    2       rows R
//   18    2       columns C
//   20    ...     counts, row by row, packed from the low bit of the first byte on
//   last  4       CRC-32 (IEEE) of all before it
//
// Plain C++11 without Arduino's core, so that a PC can test it and any other board can use it.
// SPDX-License-Identifier: MIT OR Apache-2.0
#ifndef TAXEL1_H
#define TAXEL1_H

#include <stddef.h>
#include <stdint.h>

namespace taxel1 {

// CRC-32 (IEEE). One table for each half of a byte, 128 bytes in all: the usual 1 KB is half the RAM of an ATmega328P,
// and bit by bit a frame would take it 3 ms longer.
class Crc32 {
 public:
  Crc32() {
    for (uint8_t half = 0; half < 16; half++) {
      low_[half] = remainder(half);
      high_[half] = remainder(uint8_t(half << 4));
    }
  }

  uint32_t of(const uint8_t *bytes, size_t length) const {
    uint32_t crc = 0xFFFFFFFFUL;
    for (size_t at = 0; at < length; at++) {
      const uint8_t byte = uint8_t(crc ^ bytes[at]);
      crc = (crc >> 8) ^ low_[byte & 15] ^ high_[byte >> 4];
    }
    return ~crc;
  }

 private:
  static uint32_t remainder(uint8_t byte) {
    uint32_t rest = byte;
    for (uint8_t bit = 0; bit < 8; bit++) {
      rest = (rest & 1) ? (rest >> 1) ^ 0xEDB88320UL : rest >> 1;
    }
    return rest;
  }

  uint32_t low_[16];
  uint32_t high_[16];
};

// One frame. Counts are packed as they are set and COBS is applied on the way out, so that the frame is in RAM once:
// 344 bytes for 16 x 16 counts of 10 bits.
template <uint16_t ROWS, uint16_t COLUMNS, uint8_t BITS>
class Packet {
  static_assert(BITS == 8 || BITS == 10 || BITS == 12 || BITS == 16, "taxel-1 has counts of 8, 10, 12 or 16 bits");
  static_assert(ROWS > 0 && COLUMNS > 0, "an array has rows and columns");

 public:
  // In any order; a count that is not set again stays as it was.
  void set(uint16_t row, uint16_t column, uint16_t count) {
    const size_t bit = (size_t(row) * COLUMNS + column) * BITS;
    uint8_t *const at = bytes_ + HEADER + bit / 8;
    // Of the four widths none begins so late in its byte that it would reach into a third one.
    const uint16_t mask = uint16_t(LARGEST << (bit % 8));
    const uint16_t value = uint16_t(uint16_t(count & LARGEST) << (bit % 8));
    at[0] = uint8_t((at[0] & ~mask) | value);
    if (mask >> 8) {
      at[1] = uint8_t((at[1] & ~(mask >> 8)) | (value >> 8));
    }
  }

  // Hands the packet to `put`, byte by byte, with the zero bytes around it.
  template <class Put>
  void send(uint16_t sensor_id, uint32_t sequence, uint64_t time_us, Put put) {
    bytes_[0] = 1;
    bytes_[1] = BITS;
    store(2, 2, sensor_id);
    store(4, 4, sequence);
    // In halves: 8-bit processors shift 64 bits slowly.
    store(8, 4, uint32_t(time_us));
    store(12, 4, uint32_t(time_us >> 32));
    store(16, 2, ROWS);
    store(18, 2, COLUMNS);
    store(LENGTH - CHECK, CHECK, crc32_.of(bytes_, LENGTH - CHECK));

    // The one before the packet cuts off what a reset left unfinished.
    put(uint8_t(0));
    size_t start = 0;
    bool open = true;
    while (open) {
      size_t end = start;
      while (end < LENGTH && bytes_[end] != 0 && end - start < LONGEST_RUN) {
        end++;
      }
      put(uint8_t(end - start + 1));
      for (size_t at = start; at < end; at++) {
        put(bytes_[at]);
      }
      // A run that was cut at its longest hides no zero; every other one does, but for the last.
      const bool cut = end - start == LONGEST_RUN;
      open = end < LENGTH;
      start = cut ? end : end + 1;
    }
    put(uint8_t(0));
  }

 private:
  static constexpr size_t HEADER = 20;
  static constexpr size_t CHECK = 4;
  static constexpr size_t LENGTH = HEADER + (size_t(ROWS) * COLUMNS * BITS + 7) / 8 + CHECK;
  static constexpr size_t LONGEST_RUN = 254;
  static constexpr uint16_t LARGEST = uint16_t((1UL << BITS) - 1);

  // Not memcpy: the order of bytes must not depend on the processor.
  void store(size_t at, size_t size, uint32_t value) {
    for (size_t i = 0; i < size; i++) {
      bytes_[at + i] = uint8_t(value);
      value >>= 8;
    }
  }

  Crc32 crc32_;
  uint8_t bytes_[LENGTH] = {};
};

// Goes on where a 32-bit clock of microseconds begins again, every 71.6 minutes. Must be asked more often than that.
class LongClock {
 public:
  uint64_t extend(uint32_t now_us) {
    if (now_us < last_us_) {
      wraps_++;
    }
    last_us_ = now_us;
    return (uint64_t(wraps_) << 32) | now_us;
  }

 private:
  uint32_t last_us_ = 0;
  uint32_t wraps_ = 0;
};

}  // namespace taxel1

#endif
