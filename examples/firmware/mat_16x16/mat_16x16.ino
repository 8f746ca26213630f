// Reads a 16 x 16 resistive mat with two CD74HC4067 multiplexers and sends its frames to `taxel`.
//
// The column multiplexer ties one column to 5 V and leaves the others open; the row multiplexer ties one row to the
// converter and its pull-down resistor. `taxel` calls this read-out "divider-floating" and undoes its cross-talk.
// Wiring: README.md, one folder up. For an Arduino Uno or Nano (ATmega328P at 5 V, 16 MHz).
//
// SPDX-License-Identifier: MIT OR Apache-2.0
#include "taxel1.h"

#if !defined(__AVR_ATmega328P__)
#error "Ports and converter are set up for an ATmega328P: choose the board Arduino Uno or Nano"
#endif

// The mat. A smaller one uses the first channels of each multiplexer.
constexpr uint8_t ROWS = 16;
constexpr uint8_t COLUMNS = 16;

// S0 to S3 of each multiplexer. The four must share a port of the processor (D2-D7, D8-D13 or A0-A5): then they change
// at once, and no third line is connected for a moment on the way. D0 and D1 are the serial port.
constexpr uint8_t COLUMN_PINS[4] = {4, 5, 6, 7};
constexpr uint8_t ROW_PINS[4] = {8, 9, 10, 11};

// The row multiplexer's common pin and the 1 kOhm pull-down are on A0.
constexpr uint8_t ANALOG_CHANNEL = 0;

// A sensed row falls to its own voltage through the pull-down: 1 kOhm and some 0.5 nF of mat and cable make 0.5 us,
// and half a count of 1024 takes 8 of these. The rest is for lines that float: they settle through the taxels alone,
// some 10 kOhm each when pressed. Raise both until readings no longer change: `taxel` assumes that nothing moves.
constexpr uint16_t ROW_SETTLE_US = 10;
// A new column moves every floating line of the mat, not just the two beside a switched row.
constexpr uint16_t COLUMN_SETTLE_US = 20;

// Conversions averaged per taxel, a power of two. n of them divide noise by sqrt(n) and cost 256 x 14 us each a frame.
constexpr uint8_t OVERSAMPLING = 2;

// 16 MHz / 16 = 1 MHz: a conversion takes 13 of these, 13 us instead of Arduino's 104 us. The data sheet promises 2
// counts of absolute accuracy at 200 kHz and 4.5 at 1 MHz. 32 or 64 win some of it back; 8 and less ruin the low bits.
constexpr uint8_t ADC_PRESCALER = 16;
constexpr uint8_t ADC_BITS = 10;

// 1,000,000 and 500,000 divide 16 MHz exactly; 115,200 is 2.1 % off. Take 500,000 where bytes get lost: some boards'
// USB chips do not keep up.
constexpr uint32_t BAUD = 1000000;

// Tells the recordings of several mats apart; any number.
constexpr uint16_t SENSOR_ID = 0;

constexpr uint8_t port_of(uint8_t pin) { return pin < 8 ? 0 : pin < 14 ? 1 : 2; }
constexpr bool share_a_port(const uint8_t (&pins)[4]) {
  return port_of(pins[0]) == port_of(pins[1]) && port_of(pins[1]) == port_of(pins[2]) &&
         port_of(pins[2]) == port_of(pins[3]);
}
constexpr uint8_t log2_of(uint8_t value) { return value < 2 ? 0 : 1 + log2_of(value / 2); }
constexpr bool is_power_of_two(uint8_t value) { return value == 1 << log2_of(value); }

static_assert(ROWS >= 1 && ROWS <= 16 && COLUMNS >= 1 && COLUMNS <= 16, "a CD74HC4067 has 16 channels");
static_assert(share_a_port(COLUMN_PINS), "the pins of the column multiplexer must share a port");
static_assert(share_a_port(ROW_PINS), "the pins of the row multiplexer must share a port");
static_assert(is_power_of_two(ADC_PRESCALER) && ADC_PRESCALER >= 2 && ADC_PRESCALER <= 128,
              "the prescaler is 2, 4, 8, 16, 32, 64 or 128");
static_assert(is_power_of_two(OVERSAMPLING) && OVERSAMPLING <= 32, "the sum of the conversions must fit in 16 bits");

class Multiplexer {
 public:
  void begin(const uint8_t (&pins)[4]) {
    port_ = portOutputRegister(digitalPinToPort(pins[0]));
    for (uint8_t bit = 0; bit < 4; bit++) {
      pinMode(pins[bit], OUTPUT);
      others_ &= ~digitalPinToBitMask(pins[bit]);
      for (uint8_t line = 0; line < 16; line++) {
        if (line >> bit & 1) {
          levels_[line] |= digitalPinToBitMask(pins[bit]);
        }
      }
    }
  }

  // One write to the port: four calls of digitalWrite take 15 us and pass through other lines. No interrupt of
  // Arduino's core writes to a port, so none can come between reading and writing it.
  void select(uint8_t line) { *port_ = (*port_ & others_) | levels_[line]; }

 private:
  volatile uint8_t *port_ = nullptr;
  uint8_t others_ = 0xFF;
  uint8_t levels_[16] = {};
};

Multiplexer columns;
Multiplexer rows;
taxel1::LongClock long_clock;
taxel1::Packet<ROWS, COLUMNS, ADC_BITS> packet;
uint32_t sequence = 0;

// Not analogRead: it chooses channel and reference anew each time.
uint16_t read_counts() {
  uint16_t sum = OVERSAMPLING / 2;  // rounds
  for (uint8_t i = 0; i < OVERSAMPLING; i++) {
    ADCSRA |= _BV(ADSC);
    while (ADCSRA & _BV(ADSC)) {
    }
    sum += ADC;
  }
  return sum / OVERSAMPLING;
}

// Waits for the transmitter first: then Serial has nothing to queue, and the last 64 bytes do not interrupt the next
// scan, a taxel here and there settling longer than the others.
void send_byte(uint8_t byte) {
  while (!(UCSR0A & _BV(UDRE0))) {
  }
  Serial.write(byte);
}

void setup() {
  columns.begin(COLUMN_PINS);
  rows.begin(ROW_PINS);
  // Measured against the 5 V that drive the columns: what the supply does cancels.
  ADMUX = _BV(REFS0) | ANALOG_CHANNEL;
  ADCSRA = _BV(ADEN) | log2_of(ADC_PRESCALER);
  Serial.begin(BAUD);
}

void loop() {
  const uint64_t time_us = long_clock.extend(micros());
  // Column by column, since a column takes longer to settle than a row; the packet puts them row by row.
  for (uint8_t column = 0; column < COLUMNS; column++) {
    columns.select(column);
    delayMicroseconds(COLUMN_SETTLE_US);
    for (uint8_t row = 0; row < ROWS; row++) {
      rows.select(row);
      delayMicroseconds(ROW_SETTLE_US);
      packet.set(row, column, read_counts());
    }
  }
  packet.send(SENSOR_ID, sequence, time_us, send_byte);
  sequence++;
}
