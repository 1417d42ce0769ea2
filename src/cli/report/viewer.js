"use strict";
// Shows the glTF file of the page: turn, move, zoom, play. No library, nothing from a network.
(() => {
  const $ = (id) => document.getElementById(id);

  // --- What is packed: DEFLATE (RFC 1951), at once and in every browser ---------------------------------------------
  // Canonical codes: how many there are of each length, and their symbols in order.
  const codes = (lengths) => {
    const counts = new Uint16Array(16), places = new Uint16Array(17), symbols = new Uint16Array(lengths.length);
    lengths.forEach((length) => counts[length]++);
    counts[0] = 0;
    for (let length = 1; length < 16; length++) places[length + 1] = places[length] + counts[length];
    lengths.forEach((length, symbol) => length && (symbols[places[length]++] = symbol));
    return { counts, symbols };
  };
  // What lengths and distances begin at, and how many bits are added: one more every so many codes.
  const steps = (count, each, first) => {
    const all = [];
    for (let code = 0, base = first; code < count; code++) {
      const extra = code < 2 * each ? 0 : Math.floor(code / each) - 1;
      all.push([base, extra]);
      base += 1 << extra;
    }
    return all;
  };
  const LENGTHS = [...steps(28, 4, 3), [258, 0]], DISTANCES = steps(30, 2, 1);
  const ORDER = [16, 17, 18, 0, 8, 7, 9, 6, 10, 5, 11, 4, 12, 3, 13, 2, 14, 1, 15];
  const FIXED = [
    codes(Array.from({ length: 288 }, (_, k) => (k < 144 ? 8 : k < 256 ? 9 : k < 280 ? 7 : 8))),
    codes(new Array(30).fill(5)),
  ];
  const unpacked = (packed, size) => {
    const out = new Uint8Array(size);
    let from = 0, to = 0, held = 0, count = 0;
    const bits = (wanted) => {
      for (; count < wanted; count += 8) held |= packed[from++] << count;
      const value = held & ((1 << wanted) - 1);
      held >>>= wanted;
      count -= wanted;
      return value;
    };
    const next = ({ counts, symbols }) => {
      for (let length = 1, code = 0, first = 0, index = 0; length < 16; length++) {
        code |= bits(1);
        if (code - counts[length] < first) return symbols[index + code - first];
        index += counts[length];
        first = (first + counts[length]) << 1;
        code <<= 1;
      }
      throw new Error("the page is damaged");
    };
    const own = () => {
      const [literals, distances, known] = [257 + bits(5), 1 + bits(5), 4 + bits(4)];
      const lengths = new Array(19).fill(0);
      for (let k = 0; k < known; k++) lengths[ORDER[k]] = bits(3);
      const of = codes(lengths), all = [];
      while (all.length < literals + distances) {
        const symbol = next(of);
        if (symbol < 16) all.push(symbol);
        else if (symbol === 16) all.push(...new Array(3 + bits(2)).fill(all[all.length - 1]));
        else all.push(...new Array(symbol === 17 ? 3 + bits(3) : 11 + bits(7)).fill(0));
      }
      return [codes(all.slice(0, literals)), codes(all.slice(literals))];
    };
    for (let last = 0; !last; ) {
      last = bits(1);
      const type = bits(2);
      if (type === 0) {
        [held, count] = [0, 0];
        const length = packed[from] | (packed[from + 1] << 8);
        out.set(packed.subarray(from + 4, from + 4 + length), to);
        [from, to] = [from + 4 + length, to + length];
        continue;
      }
      const [literals, distances] = type === 1 ? FIXED : own();
      for (let symbol; (symbol = next(literals)) !== 256; ) {
        if (symbol < 256) {
          out[to++] = symbol;
          continue;
        }
        const [length, more] = LENGTHS[symbol - 257];
        const end = to + length + bits(more);
        const [distance, farther] = DISTANCES[next(distances)];
        const back = distance + bits(farther);
        for (; to < end; to++) out[to] = out[to - back];
      }
    }
    return out;
  };
  const bytes = (id) =>
    unpacked(Uint8Array.from(atob($(id).textContent.trim()), (c) => c.charCodeAt(0)), Number($(id).dataset.size));
  const file = bytes("glb");
  const look = JSON.parse($("look").textContent);
  const data = JSON.parse($("data").textContent);

  // --- What can be saved -------------------------------------------------------------------------------------------
  const save = (button, name, type, content) => {
    if (!$(button)) return;
    $(button).onclick = () => {
      const link = document.createElement("a");
      link.href = URL.createObjectURL(new Blob([content()], { type }));
      link.download = name;
      link.click();
      setTimeout(() => URL.revokeObjectURL(link.href), 1000);
    };
  };
  const csv = () => {
    const raw = bytes("numbers");
    const numbers = new Float32Array(raw.buffer, 0, raw.length / 4);
    const width = data.columns.length;
    const quote = (text) => (/[",\n]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text);
    const lines = [data.columns.map(quote).join(",")];
    for (let at = 0; at < numbers.length; at += width) {
      lines.push(Array.from(numbers.subarray(at, at + width), (x) => Number(x.toPrecision(7)).toString()).join(","));
    }
    return lines.join("\n") + "\n";
  };
  save("save-scenario", data.name + ".toml", "text/plain", () => $("scenario").textContent);
  save("save-glb", data.name + ".glb", "model/gltf-binary", () => file);
  save("save-csv", data.name + ".csv", "text/csv", csv);
  save("save-json", data.name + ".json", "application/json", () => JSON.stringify(data.answer, null, 2));

  // --- The file ----------------------------------------------------------------------------------------------------
  const view = new DataView(file.buffer);
  const textLength = view.getUint32(12, true);
  const gltf = JSON.parse(new TextDecoder().decode(file.subarray(20, 20 + textLength)));
  const binary = 20 + textLength + 8;
  const read = (number) => {
    const accessor = gltf.accessors[number];
    const at = binary + (gltf.bufferViews[accessor.bufferView].byteOffset || 0) + (accessor.byteOffset || 0);
    const width = { SCALAR: 1, VEC3: 3, VEC4: 4, MAT4: 16 }[accessor.type];
    const Numbers = { 5123: Uint16Array, 5125: Uint32Array, 5126: Float32Array }[accessor.componentType];
    const part = file.slice(at, at + Numbers.BYTES_PER_ELEMENT * width * accessor.count).buffer;
    return new Numbers(part);
  };
  const clips = (gltf.animations || []).map((animation) => ({
    name: animation.name,
    channels: animation.channels.map(({ sampler, target }) => ({
      node: target.node,
      path: target.path,
      times: read(animation.samplers[sampler].input),
      values: read(animation.samplers[sampler].output),
    })),
  }));
  clips.forEach((clip) => (clip.end = Math.max(...clip.channels.map(({ times }) => times[times.length - 1]))));

  // --- Places at a time --------------------------------------------------------------------------------------------
  // Columns of a 4 × 4 matrix from translation, rotation (x, y, z, w) and scale.
  const compose = ([tx, ty, tz], [x, y, z, w], [sx, sy, sz]) => [
    sx * (1 - 2 * (y * y + z * z)), sx * 2 * (x * y + z * w), sx * 2 * (x * z - y * w), 0,
    sy * 2 * (x * y - z * w), sy * (1 - 2 * (x * x + z * z)), sy * 2 * (y * z + x * w), 0,
    sz * 2 * (x * z + y * w), sz * 2 * (y * z - x * w), sz * (1 - 2 * (x * x + y * y)), 0,
    tx, ty, tz, 1,
  ];
  const multiply = (a, b) => {
    const c = new Array(16).fill(0);
    for (let i = 0; i < 4; i++) for (let j = 0; j < 4; j++) for (let k = 0; k < 4; k++) c[4 * j + i] += a[4 * k + i] * b[4 * j + k];
    return c;
  };
  const at = ({ times, values, path }, time) => {
    const width = path === "rotation" ? 4 : 3;
    let low = 0, high = times.length - 1;
    while (high - low > 1) {
      const middle = (low + high) >> 1;
      if (times[middle] <= time) low = middle; else high = middle;
    }
    const part = Math.min(Math.max((time - times[low]) / (times[high] - times[low] || 1), 0), 1);
    const mixed = [];
    for (let k = 0; k < width; k++) mixed.push(values[low * width + k] * (1 - part) + values[high * width + k] * part);
    const length = path === "rotation" ? Math.hypot(...mixed) || 1 : 1;
    return mixed.map((x) => x / length);
  };
  const places = (clip, time) => {
    const local = gltf.nodes.map((node) => ({
      translation: node.translation || [0, 0, 0], rotation: node.rotation || [0, 0, 0, 1], scale: node.scale || [1, 1, 1],
    }));
    if (clip) clip.channels.forEach((channel) => (local[channel.node][channel.path] = at(channel, time)));
    // The root turns z up into glTF's y up; here z stays up.
    local[0] = { translation: [0, 0, 0], rotation: [0, 0, 0, 1], scale: [1, 1, 1] };
    const matrices = [];
    const visit = (node, parent) => {
      const { translation, rotation, scale } = local[node];
      matrices[node] = multiply(parent, compose(translation, rotation, scale));
      (gltf.nodes[node].children || []).forEach((child) => visit(child, matrices[node]));
    };
    visit(0, compose([0, 0, 0], [0, 0, 0, 1], [1, 1, 1]));
    return matrices;
  };

  // --- Drawing -----------------------------------------------------------------------------------------------------
  const canvas = $("canvas");
  const gl = canvas.getContext("webgl", { antialias: true, preserveDrawingBuffer: true });
  if (!gl) return void ($("still-note").hidden = false);
  const shader = (type, source) => {
    const one = gl.createShader(type);
    gl.shaderSource(one, source);
    gl.compileShader(one);
    return one;
  };
  const program = gl.createProgram();
  gl.attachShader(program, shader(gl.VERTEX_SHADER, `
    attribute vec3 position; attribute vec3 normal; attribute vec3 tint;
    uniform mat4 eye; uniform mat4 model; uniform mat3 turn; varying vec3 direction; varying vec3 tinted;
    void main() { direction = turn * normal; tinted = tint; gl_Position = eye * model * vec4(position, 1.0); }`));
  gl.attachShader(program, shader(gl.FRAGMENT_SHADER, `
    precision mediump float; uniform vec4 color; uniform float lit; varying vec3 direction; varying vec3 tinted;
    void main() {
      vec3 n = normalize(direction); float side = n.z < 0.0 ? -1.0 : 1.0;
      float light = 0.52 + 0.53 * max(0.0, side * dot(n, normalize(vec3(-0.40, 0.62, 0.68))));
      gl_FragColor = vec4(color.rgb * tinted * mix(1.0, light, lit), color.a);
    }`));
  gl.linkProgram(program);
  gl.useProgram(program);
  gl.enable(gl.DEPTH_TEST);
  gl.blendFunc(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA);
  const uniform = (name) => gl.getUniformLocation(program, name);
  const [eyeAt, modelAt, turnAt, colorAt, litAt] = ["eye", "model", "turn", "color", "lit"].map(uniform);
  const [positionAt, normalAt, tintAt] = ["position", "normal", "tint"].map((name) => gl.getAttribLocation(program, name));
  const buffer = (values) => {
    const one = gl.createBuffer();
    gl.bindBuffer(gl.ARRAY_BUFFER, one);
    gl.bufferData(gl.ARRAY_BUFFER, values, gl.STATIC_DRAW);
    return one;
  };
  // Corners one after the other: numbers of more than 16 bits are no part of the standard.
  const meshes = (gltf.meshes || []).map(({ primitives: [{ attributes, indices, material }] }) => {
    const corners = read(indices);
    const spread = (values) => {
      const out = new Float32Array(3 * corners.length);
      corners.forEach((corner, k) => out.set(values.subarray(3 * corner, 3 * corner + 3), 3 * k));
      return out;
    };
    const screen = (x) => (x <= 0.0031308 ? 12.92 * x : 1.055 * x ** (1 / 2.4) - 0.055);
    const [r, g, b, a] = gltf.materials[material].pbrMetallicRoughness.baseColorFactor;
    const [position, normal] = [attributes.POSITION, attributes.NORMAL].map((number) => spread(read(number)));
    const mesh = {
      count: corners.length, color: [screen(r), screen(g), screen(b), a], position: buffer(position), normal: buffer(normal),
    };
    if (attributes.COLOR_0 !== undefined) mesh.tint = buffer(spread(read(attributes.COLOR_0)).map(screen));
    if (attributes.JOINTS_0 !== undefined) {
      // Every corner moves with one joint alone.
      const joints = read(attributes.JOINTS_0);
      mesh.skin = { position, normal, joint: Array.from(corners, (corner) => joints[4 * corner]) };
    }
    return mesh;
  });
  const floors = {};
  for (const [name, { floor, spacing, height }] of Object.entries(look.views)) {
    // Where nothing falls there is none.
    if (!floor) continue;
    const grid = [], [[x0, y0], [x1, y1]] = floor;
    const [across, along] = [Math.round((x1 - x0) / spacing), Math.round((y1 - y0) / spacing)];
    for (let k = 0; k <= across; k++) grid.push(x0 + k * spacing, y0, height, x0 + k * spacing, y1, height);
    for (let k = 0; k <= along; k++) grid.push(x0, y0 + k * spacing, height, x1, y0 + k * spacing, height);
    floors[name] = { position: buffer(new Float32Array(grid)), count: grid.length / 3 };
  }
  // Nothing that moves is cut off before or behind, wherever the eye is.
  const depth = 4 * (look.views.start.extent + look.views.all.extent);

  const skins = (gltf.skins || []).map(({ joints, inverseBindMatrices }) => ({ joints, inverse: read(inverseBindMatrices) }));
  // Corners of a skin where its joints are; the joints turn and shift.
  const bend = (mesh, skin, matrices) => {
    const { position, normal, joint } = mesh.skin;
    const all = skin.joints.map((node, k) => multiply(matrices[node], skin.inverse.subarray(16 * k, 16 * k + 16)));
    const places = new Float32Array(position.length), directions = new Float32Array(position.length);
    for (let k = 0; k < joint.length; k++) {
      const m = all[joint[k]], [x, y, z] = [position[3 * k], position[3 * k + 1], position[3 * k + 2]];
      const [u, v, w] = [normal[3 * k], normal[3 * k + 1], normal[3 * k + 2]];
      for (let i = 0; i < 3; i++) {
        places[3 * k + i] = m[i] * x + m[4 + i] * y + m[8 + i] * z + m[12 + i];
        directions[3 * k + i] = m[i] * u + m[4 + i] * v + m[8 + i] * w;
      }
    }
    for (const [target, values] of [[mesh.position, places], [mesh.normal, directions]]) {
      gl.bindBuffer(gl.ARRAY_BUFFER, target);
      gl.bufferData(gl.ARRAY_BUFFER, values, gl.DYNAMIC_DRAW);
    }
  };

  // Where the eye is when one of the views is opened.
  const opened = (name) => {
    const { azimuth, elevation } = look.views[name];
    return { view: name, azimuth, elevation, zoom: 1, shift: [0, 0] };
  };
  const state = { ...opened(look.opens), clip: 0, time: 0, playing: false };
  // Metres in a pixel: all that the view frames is in the canvas, with a margin at each side.
  const metres = () => {
    const { framed: [across, up], margin } = look.views[state.view];
    return Math.max(across / canvas.clientWidth, up / canvas.clientHeight, 1e-9) / (1 - 2 * margin) / state.zoom;
  };
  const draw = () => {
    const view = look.views[state.view], floor = floors[state.view];
    const sharp = window.devicePixelRatio || 1;
    const [width, height] = [canvas.clientWidth, canvas.clientHeight];
    [canvas.width, canvas.height] = [width * sharp, height * sharp];
    gl.viewport(0, 0, canvas.width, canvas.height);
    gl.clearColor(1, 1, 1, 1);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    const [ca, sa, ce, se] = [Math.cos(state.azimuth), Math.sin(state.azimuth), Math.cos(state.elevation), Math.sin(state.elevation)];
    const [right, up, back] = [[-sa, ca, 0], [-se * ca, -se * sa, ce], [ce * ca, ce * sa, se]];
    const scale = 2 / metres();
    const [sx, sy, sz] = [scale / width, scale / height, -1 / depth];
    const offset = (axis) => -(axis[0] * view.center[0] + axis[1] * view.center[1] + axis[2] * view.center[2]);
    const eye = [
      sx * right[0], sy * up[0], sz * back[0], 0, sx * right[1], sy * up[1], sz * back[1], 0,
      sx * right[2], sy * up[2], sz * back[2], 0,
      sx * (offset(right) + state.shift[0]), sy * (offset(up) + state.shift[1]), sz * offset(back), 1,
    ];
    gl.uniformMatrix4fv(eyeAt, false, eye);
    gl.uniformMatrix4fv(modelAt, false, compose([0, 0, 0], [0, 0, 0, 1], [1, 1, 1]));
    gl.uniform4f(colorAt, 0.82, 0.84, 0.87, 1);
    gl.uniform1f(litAt, 0);
    gl.disableVertexAttribArray(normalAt);
    gl.vertexAttrib3f(normalAt, 0, 0, 1);
    gl.disableVertexAttribArray(tintAt);
    gl.vertexAttrib3f(tintAt, 1, 1, 1);
    gl.enableVertexAttribArray(positionAt);
    if (floor) {
      gl.bindBuffer(gl.ARRAY_BUFFER, floor.position);
      gl.vertexAttribPointer(positionAt, 3, gl.FLOAT, false, 0, 0);
      gl.drawArrays(gl.LINES, 0, floor.count);
    }
    gl.uniform1f(litAt, 1);
    gl.enableVertexAttribArray(normalAt);
    const matrices = places(clips[state.clip], state.time);
    for (const blended of [false, true]) {
      gl.depthMask(!blended);
      if (blended) gl.enable(gl.BLEND); else gl.disable(gl.BLEND);
      gltf.nodes.forEach((node, k) => {
        if (node.mesh === undefined || meshes[node.mesh].color[3] < 1 !== blended) return;
        const mesh = meshes[node.mesh], isSkin = node.skin !== undefined && mesh.skin;
        if (isSkin) bend(mesh, skins[node.skin], matrices);
        const m = isSkin ? compose([0, 0, 0], [0, 0, 0, 1], [1, 1, 1]) : matrices[k];
        // Normals turn as the columns do, divided by the squares of their lengths.
        const columns = [0, 4, 8].map((c) => {
          const column = [m[c], m[c + 1], m[c + 2]];
          const square = column[0] ** 2 + column[1] ** 2 + column[2] ** 2 || 1;
          return [right, up, back].map((axis) => (axis[0] * column[0] + axis[1] * column[1] + axis[2] * column[2]) / square);
        });
        gl.uniformMatrix4fv(modelAt, false, m);
        gl.uniformMatrix3fv(turnAt, false, columns.flat());
        gl.uniform4fv(colorAt, mesh.color);
        gl.bindBuffer(gl.ARRAY_BUFFER, mesh.position);
        gl.vertexAttribPointer(positionAt, 3, gl.FLOAT, false, 0, 0);
        gl.bindBuffer(gl.ARRAY_BUFFER, mesh.normal);
        gl.vertexAttribPointer(normalAt, 3, gl.FLOAT, false, 0, 0);
        if (mesh.tint) {
          gl.enableVertexAttribArray(tintAt);
          gl.bindBuffer(gl.ARRAY_BUFFER, mesh.tint);
          gl.vertexAttribPointer(tintAt, 3, gl.FLOAT, false, 0, 0);
        } else {
          gl.disableVertexAttribArray(tintAt);
          gl.vertexAttrib3f(tintAt, 1, 1, 1);
        }
        gl.drawArrays(gl.TRIANGLES, 0, mesh.count);
      });
    }
    gl.depthMask(true);
    if (clips.length) {
      $("time").textContent = state.time.toFixed(2) + " s";
      $("slider").value = state.time / clips[state.clip].end;
    }
  };

  // --- What a person does ------------------------------------------------------------------------------------------
  let last = 0;
  const tick = (now) => {
    if (!state.playing) return;
    state.time += Math.min((now - last) / 1000, 0.1);
    last = now;
    if (state.time > clips[state.clip].end) state.time = 0;
    draw();
    requestAnimationFrame(tick);
  };
  const play = (playing) => {
    state.playing = playing;
    $("play").textContent = playing ? "❚❚" : "▶";
    if (playing) requestAnimationFrame((now) => ((last = now), tick(now)));
  };
  const show = (clip, playing) => {
    state.clip = clip;
    state.time = 0;
    $("clip").value = clip;
    play(playing);
    draw();
  };
  $("still").hidden = true;
  canvas.hidden = false;
  canvas.onpointerdown = (event) => canvas.setPointerCapture(event.pointerId);
  canvas.onpointermove = (event) => {
    if (!event.buttons) return;
    if (event.shiftKey || event.buttons !== 1) {
      state.shift = [state.shift[0] + metres() * event.movementX, state.shift[1] - metres() * event.movementY];
    } else {
      state.azimuth -= 0.008 * event.movementX;
      state.elevation = Math.min(Math.max(state.elevation + 0.008 * event.movementY, -1.5), 1.5);
    }
    draw();
  };
  canvas.onwheel = (event) => {
    event.preventDefault();
    state.zoom = Math.min(Math.max(state.zoom * Math.exp(-0.001 * event.deltaY), 0.1), 100);
    draw();
  };
  const open = (name) => {
    Object.assign(state, opened(name));
    $("view").textContent = name === "start" ? "see all" : "see the start";
    draw();
  };
  canvas.ondblclick = () => open(state.view);
  $("view").onclick = () => open(state.view === "start" ? "all" : "start");
  canvas.oncontextmenu = (event) => event.preventDefault();
  if (clips.length) {
    $("controls").hidden = false;
    clips.forEach((clip, k) => $("clip").add(new Option(clip.name, k)));
    $("clip").onchange = () => show(Number($("clip").value), state.playing);
    $("play").onclick = () => play(!state.playing);
    $("slider").oninput = () => {
      play(false);
      state.time = $("slider").value * clips[state.clip].end;
      draw();
    };
    document.querySelectorAll("button[data-clip]").forEach((button) => {
      const number = clips.findIndex((clip) => clip.name.startsWith(button.dataset.clip));
      if (number < 0) return void (button.hidden = true);
      button.onclick = () => {
        canvas.scrollIntoView({ behavior: "smooth", block: "center" });
        show(number, true);
      };
    });
  }
  window.onresize = draw;
  open(state.view);
  document.documentElement.dataset.shown = "yes";
})();
