// Reads the server's bundles: a JSON head and typed arrays that share the answer's memory.
type Numbers = Float32Array | Uint32Array | Uint8Array;

export interface Bundle<Head> {
  head: Head;
  f32(name: string): Float32Array;
  u32(name: string): Uint32Array;
  u8(name: string): Uint8Array;
  has(name: string): boolean;
}

interface Entry { type: 'f32' | 'u32' | 'u8'; offset: number; count: number }

export function readBundle<Head>(buffer: ArrayBuffer): Bundle<Head> {
  const bytes = new Uint8Array(buffer, 0, 4);
  if (String.fromCharCode(...bytes) !== 'SNX1') throw new Error('this is not a bundle of arrays');
  const length = new DataView(buffer).getUint32(4, true);
  const head = JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, 8, length)));
  const arrays = head.arrays as Record<string, Entry>;
  const start = 8 + length;
  const find = (name: string, type: Entry['type']): Numbers => {
    const entry = arrays[name];
    if (!entry || entry.type !== type) throw new Error(`the bundle has no ${type} "${name}"`);
    const at = start + entry.offset;
    if (type === 'f32') return new Float32Array(buffer, at, entry.count);
    if (type === 'u32') return new Uint32Array(buffer, at, entry.count);
    return new Uint8Array(buffer, at, entry.count);
  };
  return {
    head,
    f32: (name) => find(name, 'f32') as Float32Array,
    u32: (name) => find(name, 'u32') as Uint32Array,
    u8: (name) => find(name, 'u8') as Uint8Array,
    has: (name) => name in arrays,
  };
}
