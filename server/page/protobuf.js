// Protocol Buffers by their descriptors: messages to and from plain objects. Fields have their names in the .proto
// files; bytes are Uint8Array, enums are numbers (their names may be written), 64-bit integers are numbers and exact
// below 2^53. A field that was not sent is absent, but for repeated ones, which are empty arrays.

const text = new TextDecoder();
const utf8 = new TextEncoder();

const kDouble = 1, kFloat = 2, kInt64 = 3, kUint64 = 4, kInt32 = 5, kBool = 8, kString = 9, kMessage = 11, kBytes = 12,
  kUint32 = 13, kEnum = 14, kSint64 = 18;
const kVarint = 0, kFixed64 = 1, kLengthDelimited = 2, kFixed32 = 5;
const kRepeated = 3;

class Reader {
  constructor(bytes) {
    this.bytes = bytes;
    this.view = new DataView(bytes.buffer, bytes.byteOffset, bytes.byteLength);
    this.at = 0;
  }

  varint() {
    let value = 0, factor = 1;
    for (;;) {
      const byte = this.bytes[this.at++];
      if (byte === undefined) throw new Error('a message ends too early');
      value += (byte & 0x7f) * factor;
      if (byte < 0x80) return value;
      factor *= 128;
    }
  }

  take(size) {
    const begin = this.at;
    this.at += size;
    if (this.at > this.bytes.length) throw new Error('a message ends too early');
    return this.bytes.subarray(begin, this.at);
  }

  // Passes (field number, wire type) of every field; `each` returns whether it has read the value.
  fields(each) {
    while (this.at < this.bytes.length) {
      const key = this.varint();
      const wire = key & 7;
      if (each(key >>> 3, wire)) continue;
      if (wire === kVarint) this.varint();
      else if (wire === kFixed64) this.take(8);
      else if (wire === kFixed32) this.take(4);
      else this.take(this.varint());
    }
  }
}

class Writer {
  constructor() { this.parts = []; this.size = 0; }

  put(bytes) { this.parts.push(bytes); this.size += bytes.length; }

  varint(value) {
    const bytes = [];
    while (value >= 128) {
      bytes.push((value % 128) | 0x80);
      value = Math.floor(value / 128);
    }
    bytes.push(value);
    this.put(Uint8Array.from(bytes));
  }

  finish() {
    const all = new Uint8Array(this.size);
    let at = 0;
    for (const part of this.parts) { all.set(part, at); at += part.length; }
    return all;
  }
}

// Reads a message of which only some fields are known: {number: [name, kind]}, kind being a function that reads bytes,
// or null for integers. All are arrays.
function readPlainly(known, bytes) {
  const read = new Reader(bytes);
  const message = Object.fromEntries(Object.values(known).map(([name]) => [name, []]));
  read.fields((number, wire) => {
    const field = known[number];
    if (!field) return false;
    message[field[0]].push(wire === kVarint ? read.varint() : field[1](read.take(read.varint())));
    return true;
  });
  return message;
}

// descriptor.proto, as far as it is needed.
const string = bytes => text.decode(bytes);
const fieldOf = bytes => readPlainly(
  {1: ['name', string], 3: ['number', null], 4: ['label', null], 5: ['type', null], 6: ['typeName', string]}, bytes);
const enumOf = bytes => readPlainly(
  {1: ['name', string], 2: ['values', b => readPlainly({1: ['name', string], 2: ['number', null]}, b)]}, bytes);
const messageOf = bytes => readPlainly(
  {1: ['name', string], 2: ['fields', fieldOf], 3: ['messages', messageOf], 4: ['enums', enumOf]}, bytes);
const methodOf = bytes => readPlainly({1: ['name', string], 2: ['input', string], 3: ['output', string]}, bytes);
const serviceOf = bytes => readPlainly({1: ['name', string], 2: ['methods', methodOf]}, bytes);
const fileOf = bytes => readPlainly(
  {2: ['package', string], 4: ['messages', messageOf], 5: ['enums', enumOf], 6: ['services', serviceOf]}, bytes);

export class Messages {
  // descriptors: a FileDescriptorSet.
  constructor(descriptors) {
    this.types = new Map();    // full name: {byName, byNumber}
    this.enums = new Map();    // full name: {name: number}
    this.methods = new Map();  // "/package.Service/Method": {input, output}
    for (const file of readPlainly({1: ['files', fileOf]}, descriptors).files) {
      const scope = `.${file.package[0] ?? ''}`;
      file.enums.forEach(one => this.#addEnum(scope, one));
      file.messages.forEach(one => this.#addType(scope, one));
      for (const service of file.services) {
        for (const method of service.methods) {
          this.methods.set(`/${scope.slice(1)}.${service.name[0]}/${method.name[0]}`,
            {input: method.input[0], output: method.output[0]});
        }
      }
    }
  }

  #addEnum(scope, one) {
    this.enums.set(`${scope}.${one.name[0]}`,
      Object.fromEntries(one.values.map(value => [value.name[0], value.number[0] ?? 0])));
  }

  #addType(scope, one) {
    const name = `${scope}.${one.name[0]}`;
    one.enums.forEach(inner => this.#addEnum(name, inner));
    one.messages.forEach(inner => this.#addType(name, inner));
    const fields = one.fields.map(field => ({
      name: field.name[0], number: field.number[0], type: field.type[0], typeName: field.typeName[0],
      repeated: field.label[0] === kRepeated,
    }));
    this.types.set(name, {
      byName: new Map(fields.map(field => [field.name, field])),
      byNumber: new Map(fields.map(field => [field.number, field])),
    });
  }

  encode(typeName, message) {
    const type = this.types.get(typeName);
    const writer = new Writer();
    for (const [name, value] of Object.entries(message)) {
      const field = type.byName.get(name);
      if (!field) throw new Error(`${typeName} has no field ${name}`);
      if (value === undefined) continue;
      if (!field.repeated) this.#write(writer, field, value);
      else for (const one of value) this.#write(writer, field, one);
    }
    return writer.finish();
  }

  #write(writer, field, value) {
    const key = wire => writer.varint(field.number * 8 + wire);
    const delimited = bytes => { key(kLengthDelimited); writer.varint(bytes.length); writer.put(bytes); };
    switch (field.type) {
      case kMessage: return delimited(this.encode(field.typeName, value));
      case kString: return delimited(utf8.encode(value));
      case kBytes: return delimited(value);
      case kDouble: key(kFixed64); return writer.put(new Uint8Array(new Float64Array([value]).buffer));
      case kFloat: key(kFixed32); return writer.put(new Uint8Array(new Float32Array([value]).buffer));
      case kEnum: key(kVarint);
        return writer.varint(typeof value === 'string' ? this.enums.get(field.typeName)[value] : value);
      default: key(kVarint); return writer.varint(Number(value));
    }
  }

  decode(typeName, bytes) {
    const type = this.types.get(typeName);
    const message = {};
    for (const field of type.byNumber.values()) if (field.repeated) message[field.name] = [];
    const reader = new Reader(bytes);
    reader.fields((number, wire) => {
      const field = type.byNumber.get(number);
      if (!field) return false;
      const packed = field.repeated && wire === kLengthDelimited && ![kMessage, kString, kBytes].includes(field.type);
      const end = packed ? reader.varint() + reader.at : 0;
      do {
        const value = this.#read(reader, field);
        if (field.repeated) message[field.name].push(value);
        else message[field.name] = value;
      } while (packed && reader.at < end);
      return true;
    });
    return message;
  }

  #read(reader, field) {
    switch (field.type) {
      case kMessage: return this.decode(field.typeName, reader.take(reader.varint()));
      case kString: return text.decode(reader.take(reader.varint()));
      case kBytes: return reader.take(reader.varint());
      case kDouble: reader.at += 8; return reader.view.getFloat64(reader.at - 8, true);
      case kFloat: reader.at += 4; return reader.view.getFloat32(reader.at - 4, true);
      case kBool: return reader.varint() !== 0;
      case kSint64: {
        const value = reader.varint();
        return value % 2 ? -(value + 1) / 2 : value / 2;
      }
      case kInt64: case kUint64: case kInt32: case kUint32: case kEnum: return reader.varint();
      default: throw new Error(`fields of type ${field.type} are not read`);
    }
  }
}
