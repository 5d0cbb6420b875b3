// What the declarations name of a page, for programs that are compiled without one, as workers are. Beside TypeScript's
// own "dom" this says nothing new.
interface MediaStreamTrack {
  readonly kind: string;
}
interface HTMLCanvasElement {
  width: number;
  height: number;
}
