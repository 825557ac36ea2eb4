// Undo and redo over whole states: plans are small.
export class History<T> {
  private past: T[] = [];
  private future: T[] = [];
  constructor(private now: T) {}
  get current(): T { return this.now; }
  get canUndo(): boolean { return this.past.length > 0; }
  get canRedo(): boolean { return this.future.length > 0; }
  /** A new state. `sameGesture`: it replaces the last one, as while a slider is dragged. */
  push(next: T, sameGesture = false): void {
    if (!sameGesture) {
      this.past.push(this.now);
      if (this.past.length > 200) this.past.shift();
    }
    this.now = next;
    this.future = [];
  }
  undo(): T {
    const last = this.past.pop();
    if (last !== undefined) { this.future.push(this.now); this.now = last; }
    return this.now;
  }
  redo(): T {
    const next = this.future.pop();
    if (next !== undefined) { this.past.push(this.now); this.now = next; }
    return this.now;
  }
}
