// The program of the WebGL 2 renderer and its uniforms.

import { FRAGMENT, VERTEX } from './glsl.js';

/** The program of all parts. */
export function program(gl) {
  const shader = (kind, text) => {
    const made = gl.createShader(kind);
    gl.shaderSource(made, text);
    gl.compileShader(made);
    if (!gl.getShaderParameter(made, gl.COMPILE_STATUS)) throw new Error(gl.getShaderInfoLog(made));
    return made;
  };
  const made = gl.createProgram();
  gl.attachShader(made, shader(gl.VERTEX_SHADER, VERTEX));
  gl.attachShader(made, shader(gl.FRAGMENT_SHADER, FRAGMENT));
  gl.linkProgram(made);
  if (!gl.getProgramParameter(made, gl.LINK_STATUS)) throw new Error(gl.getProgramInfoLog(made));
  gl.useProgram(made);
  ['baseMap', 'metalMap', 'normalMap', 'occlusionMap', 'emissiveMap', 'jointMatrices']
    .forEach((name, unit) => gl.uniform1i(gl.getUniformLocation(made, name), unit));
  return made;
}

/** A setter for each uniform, by its name. */
export function uniforms(gl, made) {
  const setters = {};
  const count = gl.getProgramParameter(made, gl.ACTIVE_UNIFORMS);
  for (let i = 0; i < count; i++) {
    const { name, type } = gl.getActiveUniform(made, i);
    const at = gl.getUniformLocation(made, name);
    setters[name] = {
      [gl.FLOAT]: (v) => gl.uniform1f(at, v),
      [gl.FLOAT_VEC3]: (v) => gl.uniform3fv(at, v),
      [gl.FLOAT_VEC4]: (v) => gl.uniform4fv(at, v),
      [gl.INT]: (v) => gl.uniform1i(at, v),
      [gl.INT_VEC4]: (v) => gl.uniform4iv(at, v),
      [gl.BOOL]: (v) => gl.uniform1i(at, v ? 1 : 0),
      [gl.FLOAT_MAT3]: (v) => gl.uniformMatrix3fv(at, false, v),
      [gl.FLOAT_MAT4]: (v) => gl.uniformMatrix4fv(at, false, v),
    }[type];
  }
  return setters;
}
