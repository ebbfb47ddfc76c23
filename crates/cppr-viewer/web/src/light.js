// The light of the picture. Intensities as three.js has them.

/** From the camera's side. */
export const KEY = 1.7;
/** From everywhere. */
export const AMBIENT = 0.55;
/** From +Y and from −Y, mixed between. */
export const SKY = { colour: "#ffffff", intensity: 1.5 };
export const GROUND = "#c8c4bd";
