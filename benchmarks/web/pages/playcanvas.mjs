// PlayCanvas engine: https://github.com/playcanvas/engine

import * as pc from "playcanvas";
import { fieldOfView, install } from "./bench.mjs";

// The engine runs its own frame loop.  Its requests for the next frame wait here until `render`.
const waiting = [];
function takeOverFrames() {
  const browser = window.requestAnimationFrame.bind(window);
  let ours = true;
  window.requestAnimationFrame = (callback) => (ours ? browser(callback) : waiting.push(callback));
  return {
    engine(action) {
      ours = false;
      try {
        return action();
      } finally {
        ours = true;
      }
    },
  };
}

function load(app, url) {
  const asset = new pc.Asset("scene", "gsplat", { url });
  app.assets.add(asset);
  return new Promise((resolve, reject) => {
    asset.on("load", () => resolve(asset));
    asset.on("error", (message) => reject(new Error(message)));
    app.assets.load(asset);
  });
}

async function makeApp(canvas) {
  const device = await pc.createGraphicsDevice(canvas, {
    deviceTypes: [pc.DEVICETYPE_WEBGL2],
    antialias: false,
    alpha: false,
  });
  device.maxPixelRatio = 1;
  const options = new pc.AppOptions();
  options.graphicsDevice = device;
  options.componentSystems = [pc.CameraComponentSystem, pc.GSplatComponentSystem];
  options.resourceHandlers = [pc.GSplatHandler];
  const app = new pc.AppBase(canvas);
  app.init(options);
  app.setCanvasFillMode(pc.FILLMODE_NONE, canvas.width, canvas.height);
  app.setCanvasResolution(pc.RESOLUTION_FIXED, canvas.width, canvas.height);
  // By default splats of little weight are left out; here every program draws all of them.
  // (Its low-pass is fixed: 0.3 in half pixels, that is 0.075 px2.)
  app.scene.gsplat.minPixelSize = 0;
  app.scene.gsplat.minContribution = 0;
  return app;
}

function addCamera(app, camera) {
  const view = new pc.Entity("camera");
  view.addComponent("camera", {
    clearColor: new pc.Color(0, 0, 0, 1),
    fov: fieldOfView(camera),
    nearClip: camera.near,
    farClip: camera.far,
    toneMapping: pc.TONEMAP_NONE,
  });
  app.root.addChild(view);
  return view;
}

async function start(url, camera) {
  const canvas = document.createElement("canvas");
  canvas.width = camera.width_px;
  canvas.height = camera.height_px;
  document.body.appendChild(canvas);
  const app = await makeApp(canvas);
  const view = addCamera(app, camera);
  const splats = new pc.Entity("splats");
  splats.addComponent("gsplat", { asset: await load(app, url) });
  app.root.addChild(splats);
  const frames = takeOverFrames();
  frames.engine(() => app.start());
  const render = (pose) => {
    view.setPosition(...pose.position);
    view.setRotation(...pose.quaternion);
    const due = waiting.splice(0);
    frames.engine(() => due.forEach((callback) => callback(performance.now())));
  };
  return { canvas, gl: app.graphicsDevice.gl, render };
}

install(start);
