// Calls of the server's services over one WebSocket (sightline/page/v1/tunnel.proto). The socket is opened again when
// it breaks; calls that were open then fail with code 14, UNAVAILABLE.

const kRequest = '.sightline.page.v1.TunnelRequest';
const kResponse = '.sightline.page.v1.TunnelResponse';
const kStatus = '.google.rpc.Status';
const kErrorInfo = '.google.rpc.ErrorInfo';
const kUnavailable = 14;
const kLongestPause = 5000;  // milliseconds between two attempts

export class CallError extends Error {
  constructor(code, message, reason) {
    super(message);
    this.code = code;
    this.reason = reason;
  }
}

export class Tunnel {
  // state(connected) is told of every change.
  constructor(messages, url, state) {
    this.messages = messages;
    this.url = url;
    this.state = state;
    this.calls = new Map();
    this.next = 1;
    this.pause = 250;
    this.authorization = '';
    this.#open();
  }

  // One request, one answer.
  async call(method, request) {
    let answer;
    await this.stream(method, [request], message => { answer = message; }).done;
    return answer;
  }

  // Sends the requests and passes every answer. `done` resolves or rejects at the end.
  stream(method, requests, each) {
    const types = this.messages.methods.get(method);
    const number = this.next++;
    const call = {types, each};
    call.done = new Promise((resolve, reject) => { call.resolve = resolve; call.reject = reject; });
    if (this.socket.readyState !== WebSocket.OPEN) {
      call.reject(new CallError(kUnavailable, 'the server cannot be reached'));
      return {done: call.done, cancel() {}};
    }
    this.calls.set(number, call);
    requests.forEach((request, index) => this.#send({
      call: number,
      ...(index === 0 && {method, authorization: this.authorization}),
      message: this.messages.encode(types.input, request),
      last: index === requests.length - 1,
    }));
    return {done: call.done, cancel: () => { if (this.calls.has(number)) this.#send({call: number, cancel: true}); }};
  }

  #send(request) { this.socket.send(this.messages.encode(kRequest, request)); }

  #open() {
    this.socket = new WebSocket(this.url);
    this.socket.binaryType = 'arraybuffer';
    this.socket.onopen = () => { this.pause = 250; this.state(true); };
    this.socket.onmessage = event => {
      try {
        this.#take(this.messages.decode(kResponse, new Uint8Array(event.data)));
      } catch {
        this.socket.close();  // the server speaks another version: its calls fail, and the socket is opened again
      }
    };
    this.socket.onclose = () => {
      this.state(false);
      for (const call of this.calls.values()) call.reject(new CallError(kUnavailable, 'the connection broke'));
      this.calls.clear();
      setTimeout(() => this.#open(), this.pause);
      this.pause = Math.min(2 * this.pause, kLongestPause);
    };
  }

  #take(response) {
    const call = this.calls.get(response.call);
    if (!call) return;
    if (response.message) {
      try {
        call.each(this.messages.decode(call.types.output, response.message));
      } catch (error) {
        call.reject(error);
      }
    }
    if (!response.end) return;
    this.calls.delete(response.call);
    const {code = 0, message = '', details} = response.end;
    if (code === 0) return call.resolve();
    call.reject(new CallError(code, message, details && this.#reason(details)));
  }

  #reason(details) {
    for (const detail of this.messages.decode(kStatus, details).details) {
      if (detail.type_url.endsWith('google.rpc.ErrorInfo'))
        return this.messages.decode(kErrorInfo, detail.value).reason;
    }
    return undefined;
  }
}
