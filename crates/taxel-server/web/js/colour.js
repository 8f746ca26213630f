// Colour maps as look-up tables. Inferno, viridis and magma are by Stéfan van der Walt, Nathaniel J.
// Smith and Eric Firing (public domain, CC0), taken at 33 even steps; between those, straight lines
// differ from the published tables by less than can be seen.

export const TABLE_SIZE = 512;

/** @type {Record<string, string>} */
const STOPS = {
  inferno:
    "0000040403120b0724150b37210c4a2f0a5b3d09654a0c6b57106e64156e71196e7d1e6d8a226a972766a32c61b0315bbc3754c63d4dd04545da4e3ce35933eb6429f1711ff67e14f98c0afb9b06fcaa0ffbba1ff9c932f5d949f2e865f3f586fcffa4",
  viridis:
    "440154470d6048186a482374472d7b4537814240863e49893b528b375b8d33638d2f6b8e2c728e297a8e26828e23898e21918c1f978b1f9f8821a68527ad8131b57b3dbc744cc26c5cc8636ece5881d34d95d840aadc32c0df25d5e21aeae51afde725",
  magma:
    "0000040303120a0822130d341d114729115a36106b440f7651127c5d177f6a1c81762181832681902a819c2e7faa337db73779c23b75cf4070db476ae55064ee5b5ef4695cf9785dfb8761fd9668fea571feb47bfec287fed194fde0a1fceeb0fcfdbf",
  greys: "000000ffffff",
};

export const COLOUR_MAPS = Object.keys(STOPS);

// Zero in the middle is dark, as it is in the maps above.
const DIFFERENCE_STOPS = "d6ecff7cc0fb3f8fe02461a8163a660c0f134a24088f4410d06a1cff9c4affe0b8";

const MISSING = [128, 134, 142];

// Colours of pins and regions: apart from each other, and legible on dark and on light ground.
export const SELECTION_COLOURS = ["#19b5d8", "#7cb82f", "#ee6aa2", "#e0a100", "#7089f5", "#18b38a", "#f0705f", "#bd72e4"];

const bigEndian = new Uint8Array(new Uint32Array([1]).buffer)[0] === 0;

export class ColourTable {
  /** @param {string} stops six hexadecimal digits each */
  constructor(stops) {
    this.bytes = new Uint8Array(4 * TABLE_SIZE);
    this.words = new Uint32Array(this.bytes.buffer);
    this.missing = word(MISSING);
    const last = stops.length / 6 - 1;
    for (let i = 0; i < TABLE_SIZE; i += 1) {
      const position = (i / (TABLE_SIZE - 1)) * last;
      const from = Math.min(Math.floor(position), last - 1);
      for (let part = 0; part < 3; part += 1) {
        const low = parseInt(stops.slice(6 * from + 2 * part, 6 * from + 2 * part + 2), 16);
        const high = parseInt(stops.slice(6 * (from + 1) + 2 * part, 6 * (from + 1) + 2 * part + 2), 16);
        this.bytes[4 * i + part] = Math.round(low + (position - from) * (high - low));
      }
      this.bytes[4 * i + 3] = 255;
    }
  }

  /** @param {number} share */
  css(share) {
    const at = 4 * Math.round(Math.min(1, Math.max(0, share)) * (TABLE_SIZE - 1));
    return `rgb(${this.bytes[at]} ${this.bytes[at + 1]} ${this.bytes[at + 2]})`;
  }
}

/**
 * The words of image data lie in memory as red, green, blue, alpha.
 * @param {number[]} parts
 */
function word([red, green, blue]) {
  if (bigEndian) return ((red << 24) | (green << 16) | (blue << 8) | 255) >>> 0;
  return ((255 << 24) | (blue << 16) | (green << 8) | red) >>> 0;
}

/** @type {Map<string, ColourTable>} */
const tables = new Map();

/** @param {string} name */
export function colourTable(name) {
  const made = tables.get(name) || new ColourTable(STOPS[name] || STOPS.inferno);
  tables.set(name, made);
  return made;
}

export const differenceTable = new ColourTable(DIFFERENCE_STOPS);
