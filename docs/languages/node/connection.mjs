// A connection to a Sightline server: services, tokens, TLS, deadlines, retries, and the reasons of errors.
import { Readable } from "node:stream";
import { setTimeout as sleep } from "node:timers/promises";
import grpc from "@grpc/grpc-js";
import protoLoader from "@grpc/proto-loader";

const DEADLINE = 60_000; // milliseconds
const ATTEMPTS = 8; // of a call that the server refuses for now
const LOCAL = /^(unix:.*|(127\.\d+\.\d+\.\d+|localhost|\[::1\]):\d+)$/;

// Calls that may be repeated where the server cannot be reached: they read, or have a request id.
const REPEATABLE = {
  "sightline.v1.RayQueryService": ["CastRays", "QueryPoints"],
  "sightline.v1.SceneService": ["GetScene", "ListScenes", "BatchGetNodes", "ApplyUpdates"],
  "sightline.v1.BlobService": ["FindMissingBlobs", "GetUploadStatus"],
};
const SERVICE_CONFIG = JSON.stringify({
  methodConfig: [{
    name: Object.entries(REPEATABLE).flatMap(([service, methods]) => methods.map((method) => ({ service, method }))),
    retryPolicy: {
      maxAttempts: 4, initialBackoff: "0.1s", maxBackoff: "2s", backoffMultiplier: 2,
      retryableStatusCodes: ["UNAVAILABLE"],
    },
  }],
});

export class Connection {
  // `protos`: the folder of the .proto files; `ca`: the PEM of an authority, for TLS.
  constructor({ endpoint, protos, token = "", ca = null }) {
    if (/[^!-~]/.test(token)) throw new Error("the token has characters other than visible ASCII");
    if (token !== "" && ca === null && !LOCAL.test(endpoint)) {
      throw new Error(`the token is not sent to ${endpoint} without encryption: name an authority`);
    }
    const files = ["query", "scene", "blob"].map((name) => `sightline/v1/${name}.proto`);
    const { sightline, google } = grpc.loadPackageDefinition(protoLoader.loadSync(
      [...files, "google/rpc/status.proto", "google/rpc/error_details.proto"],
      { includeDirs: [protos], longs: String, enums: String, defaults: true }));
    const credentials = ca === null ? grpc.credentials.createInsecure() : grpc.credentials.createSsl(ca);
    const options = { "grpc.service_config": SERVICE_CONFIG, "grpc.keepalive_time_ms": 15_000 };
    if (LOCAL.test(endpoint)) options["grpc.enable_http_proxy"] = 0;
    const { RayQueryService, SceneService, BlobService } = sightline.v1;
    this.rays = new RayQueryService(endpoint, credentials, options);
    this.scenes = new SceneService(endpoint, credentials, options);
    this.blobs = new BlobService(endpoint, credentials, options);
    this.rpc = google.rpc;
    this.token = token;
  }

  // `scene`: what the call is about, for balancers.
  metadata(scene) {
    const metadata = new grpc.Metadata();
    if (this.token !== "") metadata.set("authorization", `Bearer ${this.token}`);
    if (scene) metadata.set("x-scene", scene);
    return metadata;
  }

  // A call with one request, which may be repeated: what the server refuses for now is sent again when it says.
  async call(service, method, request) {
    for (let attempt = 1; ; ++attempt) {
      try {
        return await new Promise((resolve, reject) => service[method](request, this.metadata(request.scene),
          { deadline: Date.now() + DEADLINE }, (error, response) => (error ? reject(error) : resolve(response))));
      } catch (error) {
        const { retryDelay } = this.detailsOf(error);
        if (error.code !== grpc.status.RESOURCE_EXHAUSTED || retryDelay === null || attempt === ATTEMPTS) throw error;
        await sleep(retryDelay * (1 + Math.random()));
      }
    }
  }

  // A call with many requests and one answer, without a deadline. The pipe waits where the server reads slowly.
  send(service, method, requests, scene) {
    return new Promise((resolve, reject) => {
      const call = service[method](this.metadata(scene),
        (error, response) => (error ? reject(error) : resolve(response)));
      Readable.from(requests).pipe(call);
    });
  }

  // What a program may depend on in an error: the reason (empty: it is not the server's), and after how many
  // milliseconds the call may be repeated (null: the server does not say so).
  detailsOf(error) {
    const found = { reason: "", retryDelay: null };
    const [status] = error.metadata?.get("grpc-status-details-bin") ?? [];
    if (status === undefined) return found;
    for (const { type_url: type, value } of this.rpc.Status.deserialize(status).details) {
      if (type.endsWith("/google.rpc.ErrorInfo")) found.reason = this.rpc.ErrorInfo.deserialize(value).reason;
      if (type.endsWith("/google.rpc.RetryInfo")) {
        const { seconds, nanos } = this.rpc.RetryInfo.deserialize(value).retryDelay;
        found.retryDelay = Number(seconds) * 1e3 + nanos / 1e6;
      }
    }
    return found;
  }

  close() {
    for (const service of [this.rays, this.scenes, this.blobs]) service.close();
  }
}
