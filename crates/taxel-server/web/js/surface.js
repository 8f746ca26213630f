// The 3D surface: heights in a float texture, read by the vertex shader; one draw call a frame.

import { BODY_LIFT, bodyOf, trianglesOf } from "./body.js";
import { TABLE_SIZE } from "./colour.js";
import { partsOf, theme } from "./theme.js";

const VERTEX = `#version 300 es
precision highp float;
precision highp sampler2D;
uniform sampler2D heights;
uniform ivec2 size;          // columns, rows
uniform mat4 projection;
uniform vec4 turn;           // how the array lies on the table
uniform vec2 shift;
uniform vec2 extent;
uniform float gain;
uniform float lift;
uniform bool wrapped;        // around a handle
uniform bool rowsAreRings;
uniform vec2 steps;          // from line to line around it, from ring to ring
layout(location = 0) in vec3 onBody;
layout(location = 1) in vec3 outward;
out float share;
out vec3 normal;

float at(ivec2 taxel) {
  return max(0.0, texelFetch(heights, clamp(taxel, ivec2(0), size - 1), 0).r * gain);
}

vec2 place(vec2 taxel) {
  vec2 s = (taxel + 0.5) / vec2(size);
  return (vec2(turn.x * s.x + turn.z * s.y, turn.y * s.x + turn.w * s.y) + shift - 0.5) * extent;
}

void main() {
  ivec2 taxel = ivec2(gl_VertexID % size.x, gl_VertexID / size.x);
  share = at(taxel);
  if (wrapped) {
    ivec2 line = rowsAreRings ? ivec2(1, 0) : ivec2(0, 1);
    vec3 around = normalize(vec3(outward.z, 0, -outward.x));
    vec2 rise = 0.5 * lift / steps * vec2(at(taxel + line) - at(taxel - line), at(taxel + line.yx) - at(taxel - line.yx));
    normal = outward - rise.x * around - rise.y * cross(around, outward);
    gl_Position = projection * vec4(onBody + outward * min(share, 1.2) * lift, 1.0);
    return;
  }
  vec2 here = place(vec2(taxel));
  vec2 across = place(vec2(taxel) + vec2(1, 0)) - place(vec2(taxel) - vec2(1, 0));
  vec2 along = place(vec2(taxel) + vec2(0, 1)) - place(vec2(taxel) - vec2(0, 1));
  vec3 a = vec3(across.x, (min(1.2, at(taxel + ivec2(1, 0))) - min(1.2, at(taxel - ivec2(1, 0)))) * lift, across.y);
  vec3 b = vec3(along.x, (min(1.2, at(taxel + ivec2(0, 1))) - min(1.2, at(taxel - ivec2(0, 1)))) * lift, along.y);
  normal = cross(b, a);
  if (normal.y < 0.0) normal = -normal;
  gl_Position = projection * vec4(here.x, min(share, 1.2) * lift, here.y, 1.0);
}`;

const FRAGMENT = `#version 300 es
precision highp float;
uniform sampler2D colours;
uniform vec3 light;
in float share;
in vec3 normal;
out vec4 colour;
void main() {
  vec3 base = texture(colours, vec2(clamp(share, 0.001, 0.999), 0.5)).rgb;
  float light = 0.62 + 0.46 * max(0.0, dot(normalize(normal), light));
  colour = vec4(base * light + 0.035, 1.0);
}`;

const PLAIN_VERTEX = `#version 300 es
uniform mat4 projection;
in vec3 position;
void main() { gl_Position = projection * vec4(position, 1.0); }`;

const PLAIN_FRAGMENT = `#version 300 es
precision mediump float;
uniform vec4 ink;
out vec4 colour;
void main() { colour = ink; }`;

const LIFT = 0.42;
// Where light comes from over a flat array.
const LIGHT = [-0.45, 0.8, 0.4].map((part) => part / Math.hypot(0.45, 0.8, 0.4));
const FIELD_OF_VIEW = 0.6;
// A flat array is looked at from above, a handle from its side: from opposite its seam.
const FLAT_HOME = { yaw: -0.5, pitch: 0.72 };
const BODY_PITCH = 0.3;

export class Camera {
  home = FLAT_HOME;
  yaw = FLAT_HOME.yaw;
  pitch = FLAT_HOME.pitch;
  distance = 2.25;

  reset() {
    this.yaw = this.home.yaw;
    this.pitch = this.home.pitch;
    this.distance = 2.25;
  }

  /** @param {import("./body.js").Body | null} body what it looks at; null for a flat array */
  lookAt(body) {
    const home = body ? { yaw: body.middle, pitch: BODY_PITCH } : FLAT_HOME;
    if (home.yaw === this.home.yaw && home.pitch === this.home.pitch) return;
    this.home = home;
    this.reset();
  }

  // Where light comes from: from the left of the eye and above it.
  get light() {
    const cy = Math.cos(this.yaw), sy = Math.sin(this.yaw);
    const [x, y, z] = [-0.45, 0.5, 0.74];
    return [cy * x + sy * z, y, -sy * x + cy * z];
  }

  /**
   * @param {number} dx
   * @param {number} dy
   */
  drag(dx, dy) {
    this.yaw += dx * 0.008;
    this.pitch = Math.min(1.55, Math.max(0.05, this.pitch + dy * 0.008));
  }

  /** @param {number} factor */
  zoom(factor) {
    this.distance = Math.min(6, Math.max(1.2, this.distance * factor));
  }

  /**
   * Column-major, as WebGL takes it.
   * @param {number} aspect
   */
  matrix(aspect) {
    const focal = 1 / Math.tan(FIELD_OF_VIEW / 2);
    // A tall canvas would cut off the sides: there the width decides.
    const fx = aspect > 1.45 ? focal / aspect : focal / 1.45;
    const fy = aspect > 1.45 ? focal : (focal * aspect) / 1.45;
    const near = 0.1, far = 20;
    const cy = Math.cos(this.yaw), sy = Math.sin(this.yaw), cp = Math.cos(this.pitch), sp = Math.sin(this.pitch);
    // Rows of the view: turn about the upright axis, then tip towards the eye, then step back.
    const view = [[cy, 0, -sy, 0], [-sp * sy, cp, -sp * cy, 0.02], [cp * sy, sp, cp * cy, -this.distance]];
    const zz = (far + near) / (near - far);
    const zw = (2 * far * near) / (near - far);
    const m = new Float32Array(16);
    for (let column = 0; column < 4; column += 1) {
      m[4 * column] = fx * view[0][column];
      m[4 * column + 1] = fy * view[1][column];
      m[4 * column + 2] = zz * view[2][column] + (column === 3 ? zw : 0);
      m[4 * column + 3] = -view[2][column];
    }
    return m;
  }
}

export class Surface {
  /**
   * @param {HTMLCanvasElement} canvas
   * @param {Camera} camera
   */
  static create(canvas, camera) {
    const gl = canvas.getContext("webgl2", { antialias: true, alpha: true });
    return gl ? new Surface(gl, camera) : null;
  }

  /**
   * @param {WebGL2RenderingContext} gl
   * @param {Camera} camera
   */
  constructor(gl, camera) {
    this.gl = gl;
    this.camera = camera;
    this.lost = false;
    this.rows = 1;
    this.columns = 1;
    /** @type {Wire.SensorFacts | null} */
    this.sensor = null;
    /** @type {import("./body.js").Body | null} */
    this.body = null;
    this.indexCount = 0;
    this.extent = [1, 1];
    this.turn = [1, 0, 0, 1, 0, 0];
    this.projection = new Float32Array(16);
    gl.canvas.addEventListener("webglcontextlost", (event) => {
      event.preventDefault();
      this.lost = true;
    });
    gl.canvas.addEventListener("webglcontextrestored", () => {
      this.lost = false;
      this.made = prepare(gl);
      if (this.sensor) this.setSensor(this.sensor);
    });
    this.made = prepare(gl);
  }

  /** @param {Wire.SensorFacts} sensor */
  setSensor(sensor) {
    const { gl, made } = this;
    const { rows, columns } = sensor;
    this.sensor = sensor;
    this.rows = rows;
    this.columns = columns;
    this.body = bodyOf(sensor);
    this.camera.lookAt(this.body);
    gl.bindTexture(gl.TEXTURE_2D, made.heightTexture);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.R32F, columns, rows, 0, gl.RED, gl.FLOAT, null);
    const indices = trianglesOf(rows, columns, this.body);
    this.indexCount = indices.length;
    gl.bindVertexArray(made.surfaceArray);
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, made.indexBuffer);
    gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, indices, gl.STATIC_DRAW);
    for (const [at, values] of /** @type {[number, Float32Array | undefined][]} */ ([[0, this.body?.places], [1, this.body?.outward]])) {
      if (!values) {
        gl.disableVertexAttribArray(at);
        continue;
      }
      gl.bindBuffer(gl.ARRAY_BUFFER, made.onBody[at]);
      gl.bufferData(gl.ARRAY_BUFFER, values, gl.STATIC_DRAW);
      gl.enableVertexAttribArray(at);
      gl.vertexAttribPointer(at, 3, gl.FLOAT, false, 0, 0);
    }
    gl.bindVertexArray(null);
  }

  /**
   * @param {Float32Array} values
   * @param {import("./colour.js").ColourTable} table
   * @param {number} gain
   * @param {import("./orientation.js").Orientation} orientation
   * @param {[number, number]} pitch
   */
  draw(values, table, gain, orientation, pitch) {
    if (this.lost) return;
    const { gl, made } = this;
    const { at } = made;
    const tall = this.rows * pitch[0];
    const wide = this.columns * pitch[1];
    const [width, depth] = orientation.turned ? [tall, wide] : [wide, tall];
    const diagonal = Math.hypot(width, depth);
    this.extent = [(1.8 * width) / diagonal, (1.8 * depth) / diagonal];
    this.turn = orientation.matrix();
    this.projection = this.camera.matrix(gl.canvas.width / gl.canvas.height);
    gl.viewport(0, 0, gl.canvas.width, gl.canvas.height);
    gl.clearColor(0, 0, 0, 0);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    gl.enable(gl.DEPTH_TEST);

    gl.useProgram(made.program);
    gl.activeTexture(gl.TEXTURE0);
    gl.bindTexture(gl.TEXTURE_2D, made.heightTexture);
    gl.texSubImage2D(gl.TEXTURE_2D, 0, 0, 0, this.columns, this.rows, gl.RED, gl.FLOAT, values);
    gl.activeTexture(gl.TEXTURE1);
    gl.bindTexture(gl.TEXTURE_2D, made.colourTexture);
    if (made.table !== table) {
      made.table = table;
      gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA, TABLE_SIZE, 1, 0, gl.RGBA, gl.UNSIGNED_BYTE, table.bytes);
    }
    gl.uniform1i(at.heights, 0);
    gl.uniform1i(at.colours, 1);
    gl.uniform2i(at.size, this.columns, this.rows);
    gl.uniformMatrix4fv(at.projection, false, this.projection);
    gl.uniform4f(at.turn, this.turn[0], this.turn[1], this.turn[2], this.turn[3]);
    gl.uniform2f(at.shift, this.turn[4], this.turn[5]);
    gl.uniform2f(at.extent, this.extent[0], this.extent[1]);
    gl.uniform1f(at.gain, gain);
    gl.uniform1f(at.lift, this.lift);
    const { body } = this;
    gl.uniform1i(at.wrapped, body ? 1 : 0);
    gl.uniform1i(at.rowsAreRings, body && body.rowsAreRings ? 1 : 0);
    gl.uniform2fv(at.steps, body ? body.steps : [1, 1]);
    gl.uniform3fv(at.light, body ? this.camera.light : LIGHT);
    gl.bindVertexArray(made.surfaceArray);
    gl.drawElements(gl.TRIANGLES, this.indexCount, gl.UNSIGNED_INT, 0);
    if (body) {
      this.drawPlain(body.core, gl.TRIANGLES, theme.line);
      this.drawPlain(body.edges, gl.LINES, theme.ink3);
    } else {
      this.drawOutline();
    }
  }

  // How high a taxel of the full scale stands.
  get lift() {
    return this.body ? BODY_LIFT : LIFT;
  }

  // The edge of the array on the table, and an upright with the height of the full scale.
  drawOutline() {
    const { gl } = this;
    const [x, z] = [this.extent[0] / 2, this.extent[1] / 2];
    const corners = [-x, 0, -z, x, 0, -z, x, 0, -z, x, 0, z, x, 0, z, -x, 0, z, -x, 0, z, -x, 0, -z, -x, 0, -z, -x, LIFT, -z];
    this.drawPlain(new Float32Array(corners), gl.LINES, theme.ink3);
  }

  /**
   * @param {Float32Array} corners
   * @param {number} mode
   * @param {string} ink
   */
  drawPlain(corners, mode, ink) {
    const { gl, made } = this;
    gl.useProgram(made.plain);
    gl.bindVertexArray(made.outlineArray);
    gl.bindBuffer(gl.ARRAY_BUFFER, made.outline);
    gl.bufferData(gl.ARRAY_BUFFER, corners, gl.DYNAMIC_DRAW);
    gl.enableVertexAttribArray(0);
    gl.vertexAttribPointer(0, 3, gl.FLOAT, false, 0, 0);
    gl.uniformMatrix4fv(made.plainAt.projection, false, this.projection);
    const [red, green, blue] = partsOf(ink);
    gl.uniform4f(made.plainAt.ink, red, green, blue, 1);
    gl.drawArrays(mode, 0, corners.length / 3);
    gl.bindVertexArray(null);
  }

  /**
   * Where a taxel stands that is so high, in the scene.
   * @param {number} column
   * @param {number} row
   * @param {number} high
   */
  stands(column, row, high) {
    const { body, turn: t } = this;
    if (body) {
      const at = 3 * (Math.floor(row) * this.columns + Math.floor(column));
      return [0, 1, 2].map((axis) => body.places[at + axis] + high * body.outward[at + axis]);
    }
    const u = column / this.columns, v = row / this.rows;
    return [(t[0] * u + t[2] * v + t[4] - 0.5) * this.extent[0], high, (t[1] * u + t[3] * v + t[5] - 0.5) * this.extent[1]];
  }

  /**
   * Where a taxel stands in the picture, in CSS pixels.
   * @param {number} column
   * @param {number} row
   * @param {number} share
   * @param {number} width
   * @param {number} height
   */
  project(column, row, share, width, height) {
    const [x, y, z] = this.stands(column, row, Math.min(1.2, Math.max(0, share || 0)) * this.lift);
    const m = this.projection;
    const w = m[3] * x + m[7] * y + m[11] * z + m[15];
    return {
      x: (((m[0] * x + m[4] * y + m[8] * z + m[12]) / w + 1) / 2) * width,
      y: ((1 - (m[1] * x + m[5] * y + m[9] * z + m[13]) / w) / 2) * height,
    };
  }
}

/**
 * What a context needs once, and again when it was lost.
 * @param {WebGL2RenderingContext} gl
 */
function prepare(gl) {
  const program = link(gl, VERTEX, FRAGMENT);
  const plain = link(gl, PLAIN_VERTEX, PLAIN_FRAGMENT);
  /** @param {string} name */
  const at = (name) => gl.getUniformLocation(program, name);
  return {
    program, plain,
    at: {
      heights: at("heights"), colours: at("colours"), size: at("size"), projection: at("projection"), turn: at("turn"),
      shift: at("shift"), extent: at("extent"), gain: at("gain"), lift: at("lift"),
      wrapped: at("wrapped"), rowsAreRings: at("rowsAreRings"), steps: at("steps"), light: at("light"),
    },
    plainAt: { projection: gl.getUniformLocation(plain, "projection"), ink: gl.getUniformLocation(plain, "ink") },
    heightTexture: texture(gl, gl.NEAREST),
    colourTexture: texture(gl, gl.LINEAR),
    /** @type {import("./colour.js").ColourTable | null} the one that is in the texture */
    table: null,
    indexBuffer: gl.createBuffer(),
    onBody: [gl.createBuffer(), gl.createBuffer()],
    outline: gl.createBuffer(),
    surfaceArray: gl.createVertexArray(),
    outlineArray: gl.createVertexArray(),
  };
}

/**
 * @param {WebGL2RenderingContext} gl
 * @param {number} filter
 */
function texture(gl, filter) {
  const made = gl.createTexture();
  gl.bindTexture(gl.TEXTURE_2D, made);
  gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, filter);
  gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MAG_FILTER, filter);
  gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_WRAP_S, gl.CLAMP_TO_EDGE);
  gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_WRAP_T, gl.CLAMP_TO_EDGE);
  return made;
}

/**
 * @param {WebGL2RenderingContext} gl
 * @param {string} vertex
 * @param {string} fragment
 */
function link(gl, vertex, fragment) {
  const program = gl.createProgram();
  for (const [type, text] of /** @type {[number, string][]} */ ([[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]])) {
    const shader = gl.createShader(type);
    // Where the context was lost there is none.
    if (!shader) continue;
    gl.shaderSource(shader, text);
    gl.compileShader(shader);
    gl.attachShader(program, shader);
  }
  gl.linkProgram(program);
  if (!gl.getProgramParameter(program, gl.LINK_STATUS) && !gl.isContextLost()) {
    throw new Error(`the shaders of the surface do not link: ${gl.getProgramInfoLog(program)}`);
  }
  return program;
}
