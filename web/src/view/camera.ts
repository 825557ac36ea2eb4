// One camera for every pane, moved as in 3D Slicer. Patient axes: +x left, +y posterior, +z superior.
import { PerspectiveCamera, Vector3 } from 'three';

export type StandardView = 'front' | 'back' | 'left' | 'right' | 'above' | 'below' | 'left-oblique' | 'right-oblique';
const degrees = Math.PI / 180;

/** Direction from the patient to the eye, as azimuth around +z (0: from the front) and elevation. */
const standard: Record<StandardView, [number, number]> = {
  front: [0, 0], back: [180, 0], left: [90, 0], right: [-90, 0],
  above: [0, 89.9], below: [0, -89.9], 'left-oblique': [45, 0], 'right-oblique': [-45, 0],
};

export class Orbit {
  readonly camera = new PerspectiveCamera(22, 1, 10, 8000);
  readonly target = new Vector3();
  azimuth = 0;
  elevation = 0;
  roll = 0;
  distance = 900;
  home = { target: new Vector3(), distance: 900 };
  constructor(private readonly changed: () => void) {}

  view(name: StandardView): void {
    [this.azimuth, this.elevation] = standard[name].map((d) => d * degrees);
    this.roll = 0;
    this.apply();
  }
  reset(): void {
    this.target.copy(this.home.target);
    this.distance = this.home.distance;
    this.view('front');
  }
  rotate(right: number, up: number): void {
    this.azimuth -= right;
    this.elevation = Math.max(-1.569, Math.min(1.569, this.elevation + up));
    this.apply();
  }
  pan(right: number, up: number): void {
    const m = this.camera.matrixWorld.elements;
    const scale = this.distance * Math.tan(11 * degrees) * 2;
    this.target.addScaledVector(new Vector3(m[0], m[1], m[2]), -right * scale)
      .addScaledVector(new Vector3(m[4], m[5], m[6]), -up * scale);
    this.apply();
  }
  zoom(factor: number): void {
    this.distance = Math.max(80, Math.min(4000, this.distance * factor));
    this.apply();
  }
  apply(): void {
    const c = Math.cos(this.elevation);
    // From the front the eye is at -y; the patient's left (+x) is on the right of the picture.
    const away = new Vector3(Math.sin(this.azimuth) * c, -Math.cos(this.azimuth) * c, Math.sin(this.elevation));
    this.camera.position.copy(this.target).addScaledVector(away, this.distance);
    this.camera.up.set(0, 0, 1).applyAxisAngle(away, this.roll);
    this.camera.lookAt(this.target);
    this.camera.updateMatrixWorld();
    this.changed();
  }
  /** The letter at each edge of the picture, and what the eye looks along. */
  letters(): { right: string; left: string; top: string; bottom: string } {
    const m = this.camera.matrixWorld.elements;
    const right = letterOf(m[0], m[1], m[2]), top = letterOf(m[4], m[5], m[6]);
    return { right, left: opposite[right], top, bottom: opposite[top] };
  }
}

const opposite: Record<string, string> = { L: 'R', R: 'L', A: 'P', P: 'A', S: 'I', I: 'S' };
export function letterOf(x: number, y: number, z: number): string {
  const size = [Math.abs(x), Math.abs(y), Math.abs(z)];
  if (size[0] >= size[1] && size[0] >= size[2]) return x > 0 ? 'L' : 'R';
  if (size[1] >= size[2]) return y > 0 ? 'P' : 'A';
  return z > 0 ? 'S' : 'I';
}

/** Slicer's mouse and key map (docs/user/planner.md); returns what undoes it. */
export function listenToUser(element: HTMLElement, orbit: Orbit, click: (x: number, y: number) => void): void {
  const pointers = new Map<number, { x: number; y: number }>();
  let moved = 0;
  element.addEventListener('contextmenu', (e) => e.preventDefault());
  element.addEventListener('pointerdown', (e) => {
    if (pointers.size === 0) moved = 0;
    pointers.set(e.pointerId, { x: e.clientX, y: e.clientY });
    element.setPointerCapture(e.pointerId);
  });
  element.addEventListener('pointermove', (e) => {
    const last = pointers.get(e.pointerId);
    if (!last) return;
    const dx = (e.clientX - last.x) / element.clientHeight, dy = (e.clientY - last.y) / element.clientHeight;
    moved += Math.hypot(e.clientX - last.x, e.clientY - last.y);
    if (pointers.size === 2) {
      const [a, b] = [...pointers.values()];
      const before = Math.hypot(a.x - b.x, a.y - b.y);
      last.x = e.clientX; last.y = e.clientY;
      const after = Math.hypot(a.x - b.x, a.y - b.y);
      if (after > 0 && before > 0) orbit.zoom(before / after);
      orbit.pan(dx / 2, -dy / 2);
      return;
    }
    last.x = e.clientX; last.y = e.clientY;
    if (moved < 4) return;
    if (e.buttons & 4 || (e.buttons & 1 && e.shiftKey)) orbit.pan(dx, -dy);
    else if (e.buttons & 2) orbit.zoom(Math.exp(2 * dy));
    else if (e.buttons & 1 && e.ctrlKey) { orbit.roll += 3 * dx; orbit.apply(); }
    else if (e.buttons & 1) orbit.rotate(3 * dx, 3 * dy);
  });
  const up = (e: PointerEvent): void => {
    const was = pointers.delete(e.pointerId);
    if (was && e.type === 'pointerup' && moved < 4 && e.button === 0 && pointers.size === 0) click(e.clientX, e.clientY);
  };
  element.addEventListener('pointerup', up);
  element.addEventListener('pointercancel', up);
  element.addEventListener('wheel', (e) => {
    e.preventDefault();
    orbit.zoom(Math.exp(0.001 * e.deltaY));
  }, { passive: false });
  element.addEventListener('keydown', (e) => {
    if (onKey(e, orbit)) e.preventDefault();
  });
}

function onKey(e: KeyboardEvent, orbit: Orbit): boolean {
  const arrows: Record<string, [number, number]> = {
    ArrowLeft: [-0.1, 0], ArrowRight: [0.1, 0], ArrowUp: [0, 0.1], ArrowDown: [0, -0.1],
  };
  if (e.ctrlKey || e.metaKey || e.altKey) return false;
  if (arrows[e.key]) {
    const [x, y] = arrows[e.key];
    if (e.shiftKey) orbit.pan(x / 3, y / 3); else orbit.rotate(x, -y);
  } else if (e.key === 'End') orbit.view(e.shiftKey ? 'back' : 'front');
  else if (e.key === 'PageDown') orbit.view(e.shiftKey ? 'right' : 'left');
  else if (e.key === 'Home') orbit.view(e.shiftKey ? 'below' : 'above');
  else if (e.key === 'r') orbit.reset();
  else if (e.key === '+' || e.key === '=') orbit.zoom(0.9);
  else if (e.key === '-') orbit.zoom(1 / 0.9);
  else return false;
  return true;
}
