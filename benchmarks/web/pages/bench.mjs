// The frame loop that times a viewer, and the camera in the axes of WebGL.
//
// A viewer is { canvas, gl, render(pose) }.  A frame's time runs from before `render` until one pixel of
// the canvas has been read back, so everything that the software driver had to draw is in it; what
// the browser needs to show the canvas is not, but it is in `intervals_ms`.

// Added to the variance of every footprint; wzviewer's value.  The viewers' own, up to 0.3, draws
// larger footprints and so takes longer.
export const LOW_PASS_PX2 = 0.02;

const SETTLE_MS = 2500; // sorts arrive from a worker, some of them late
const now = () => performance.now();
const nextFrame = () => new Promise((resolve) => requestAnimationFrame(resolve));

// Blocks until the driver has drawn the canvas.
function finish(gl) {
  const framebuffer = gl.getParameter(gl.READ_FRAMEBUFFER_BINDING);
  const buffer = gl.getParameter(gl.PIXEL_PACK_BUFFER_BINDING); // or the read would not reach us
  gl.bindFramebuffer(gl.READ_FRAMEBUFFER, null);
  gl.bindBuffer(gl.PIXEL_PACK_BUFFER, null);
  const pixel = new Uint8Array(4);
  gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, pixel);
  gl.bindBuffer(gl.PIXEL_PACK_BUFFER, buffer);
  gl.bindFramebuffer(gl.READ_FRAMEBUFFER, framebuffer);
  if (pixel[3] !== 255) throw new Error("the pixel was not read back: times would be void");
}

// The inverse of a rigid camera_from_world in OpenCV's axes, as position and quaternion (xyzw) of a
// camera that looks along its -z with y up.
export function poseOf(matrix) {
  const [r0, r1, r2] = matrix;
  const position = [0, 1, 2].map((k) => -(r0[k] * r0[3] + r1[k] * r1[3] + r2[k] * r2[3]));
  const m = [r0, r1.map((v) => -v), r2.map((v) => -v)]; // rows: the camera's axes in the world
  return { position, quaternion: quaternionOfAxes(m) };
}

// Shepperd's method; rows are the images of x, y, z, so the matrix is their transpose.
function quaternionOfAxes([x, y, z]) {
  const candidates = [
    [1 + x[0] - y[1] - z[2], y[0] + x[1], z[0] + x[2], y[2] - z[1]],
    [y[0] + x[1], 1 - x[0] + y[1] - z[2], z[1] + y[2], z[0] - x[2]],
    [z[0] + x[2], z[1] + y[2], 1 - x[0] - y[1] + z[2], x[1] - y[0]],
    [y[2] - z[1], z[0] - x[2], x[1] - y[0], 1 + x[0] + y[1] + z[2]],
  ];
  const best = candidates.reduce((a, b) => (Math.hypot(...b) > Math.hypot(...a) ? b : a));
  return best.map((v) => v / Math.hypot(...best));
}

// Vertical field of view, degrees.
export function fieldOfView(camera) {
  return (360 / Math.PI) * Math.atan(camera.height_px / 2 / camera.focal_px);
}

// There and back again through the poses.
function bouncing(index, count) {
  const at = index % (2 * count - 2);
  return at < count ? at : 2 * count - 2 - at;
}

class Loop {
  constructor(viewer, poses) {
    Object.assign(this, { viewer, poses, index: 0, finished: now() });
  }

  async frame(pose) {
    await nextFrame();
    const started = now();
    this.viewer.render(pose);
    finish(this.viewer.gl);
    const finished = now();
    const times = { frame_ms: finished - started, interval_ms: finished - this.finished };
    this.finished = finished;
    return times;
  }

  async settle(pose) {
    const until = now() + SETTLE_MS;
    do await this.frame(pose);
    while (now() < until);
  }

  async run(frames) {
    const times = [];
    for (let i = 0; i < frames; i++) {
      times.push(await this.frame(this.poses[bouncing(this.index++, this.poses.length)]));
    }
    return times;
  }
}

function rendererName(gl) {
  const info = gl.getExtension("WEBGL_debug_renderer_info");
  return String(gl.getParameter(info ? info.UNMASKED_RENDERER_WEBGL : gl.RENDERER));
}

// Installs window.timeViewer; `start(url, camera)` resolves to a viewer when its scene is loaded.
export function install(start) {
  window.timeViewer = async ({ scene, frames, runs, warm }) => {
    const camera = await (await fetch("/scenes/camera.json")).json();
    const poses = camera.camera_from_world.map(poseOf);
    const began = now();
    const viewer = await start(`/scenes/${scene}.ply`, camera);
    const load_ms = now() - began;
    const loop = new Loop(viewer, poses);
    await loop.settle(poses[0]);
    await loop.run(warm);
    const times = [];
    for (let i = 0; i < runs; i++) times.push(await loop.run(frames));
    await loop.settle(poses[0]);
    await loop.frame(poses[0]);
    return {
      renderer: rendererName(viewer.gl),
      size_px: [viewer.canvas.width, viewer.canvas.height],
      load_ms,
      runs_ms: times.map((run) => run.map((t) => t.frame_ms)),
      intervals_ms: times.map((run) => run.map((t) => t.interval_ms)),
      picture: viewer.canvas.toDataURL("image/png"), // in the task that drew it
    };
  };
}
