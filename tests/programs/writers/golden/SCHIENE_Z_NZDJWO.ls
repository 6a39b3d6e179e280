/PROG  SCHIENE_Z_NZDJWO
/ATTR
OWNER		= MNEDITOR;
COMMENT		= "elastocal";
PROG_SIZE	= 0;
CREATE		= DATE 00-01-01  TIME 00:00:00;
MODIFIED	= DATE 00-01-01  TIME 00:00:00;
FILE_NAME	= ;
VERSION		= 0;
LINE_COUNT	= 96;
MEMORY_SIZE	= 0;
PROTECT		= READ_WRITE;
TCD:  STACK_SIZE	= 0,
      TASK_PRIORITY	= 50,
      TIME_SLICE	= 0,
      BUSY_LAMP_OFF	= 0,
      ABORT_REQUEST	= 0,
      PAUSE_REQUEST	= 0;
DEFAULT_GROUP	= 1,*,*,*,*;
CONTROL_CODE	= 00000000 00000000;
/MN
   1:  !Calibration campaign: 3 ;
   2:  !experiments in 2 configurations. ;
   3:  !Made by elastocal 0.1.0 from ;
   4:  !Schiene - Zelle 3 (Sud). ;
   5:  !plan sha256 0123456789abcdef ;
   6:  !Start: load all of ;
   7:  !SCHIENE_Z_NZDJWO, select ;
   8:  !SCHIENE_Z_NZDJWO, run it in T1 ;
   9:  !first. ;
  10:  !Robot: arm on a rail. Joint ;
  11:  !values: deg, mm, as in the ;
  12:  !model. ;
  13:  !Forces act at the load point of ;
  14:  !the tool, in the axes of the ;
  15:  !robot base. ;
  16:  !Not watched: the robot against ;
  17:  !itself, floor. ;
  18:  !SAFETY: check this program at ;
  19:  !low speed in manual mode first. ;
  20:  !Motions between the points are ;
  21:  !not checked for collisions by ;
  22:  !this file. ;
  23:  !Set the payload of the empty ;
  24:  !calibration tool and leave it ;
  25:  !so, loaded and unloaded: the ;
  26:  !controller must not compensate ;
  27:  !what is to be measured. ;
  28:  !elastocal program 000000000000 ;
  29:  UFRAME_NUM=0 ;
  30:  UTOOL_NUM=1 ;
  31:  !to H0 ;
  32:J P[1] 25% FINE    ;
  33:  !to AP1 ;
  34:J P[2] 25% FINE    ;
  35:  !to P1 ;
  36:J P[3] 25% FINE    ;
  37:  WAIT   2.00(sec) ;
  38:  MESSAGE[Experiment 1/3: pose 1.] ;
  39:  MESSAGE[NO load. Measure M1.] ;
  40:  PAUSE ;
  41:  MESSAGE[Experiment 1/3: apply] ;
  42:  MESSAGE[374.63 N, Fx 100 Fy] ;
  43:  MESSAGE[-200.5 Fz -300.25 N.] ;
  44:  PAUSE ;
  45:  WAIT   2.00(sec) ;
  46:  MESSAGE[Experiment 1/3: pose 1.] ;
  47:  MESSAGE[LOADED. Measure M1.] ;
  48:  PAUSE ;
  49:  MESSAGE[Experiment 1/3: take the] ;
  50:  MESSAGE[load off. The robot] ;
  51:  MESSAGE[moves next.] ;
  52:  PAUSE ;
  53:  !to AP2 ;
  54:J P[4] 25% FINE    ;
  55:  !to P2 ;
  56:J P[5] 25% FINE    ;
  57:  WAIT   2.00(sec) ;
  58:  MESSAGE[Experiment 2/3: pose 2.] ;
  59:  MESSAGE[NO load. Measure M1.] ;
  60:  PAUSE ;
  61:  MESSAGE[Experiment 2/3: hang 10] ;
  62:  MESSAGE[kg, Fx 0 Fy 0 Fz -98.07] ;
  63:  MESSAGE[N, Tx 1.5 Ty 0 Tz -2] ;
  64:  MESSAGE[N.m.] ;
  65:  PAUSE ;
  66:  WAIT   2.00(sec) ;
  67:  MESSAGE[Experiment 2/3: pose 2.] ;
  68:  MESSAGE[LOADED. Measure M1.] ;
  69:  PAUSE ;
  70:  MESSAGE[Experiment 2/3: take the] ;
  71:  MESSAGE[load off. The robot] ;
  72:  MESSAGE[moves next.] ;
  73:  PAUSE ;
  74:  !to AP2 ;
  75:J P[4] 25% FINE    ;
  76:  !to P2 ;
  77:J P[5] 25% FINE    ;
  78:  WAIT   2.00(sec) ;
  79:  MESSAGE[Experiment 3/3: pose 2.] ;
  80:  MESSAGE[NO load. Measure M1.] ;
  81:  PAUSE ;
  82:  MESSAGE[Experiment 3/3: hang 10] ;
  83:  MESSAGE[kg, Fx 0 Fy 0 Fz -98.07] ;
  84:  MESSAGE[N, Tx 1.5 Ty 0 Tz -2] ;
  85:  MESSAGE[N.m.] ;
  86:  PAUSE ;
  87:  WAIT   2.00(sec) ;
  88:  MESSAGE[Experiment 3/3: pose 2.] ;
  89:  MESSAGE[LOADED. Measure M1.] ;
  90:  PAUSE ;
  91:  MESSAGE[Experiment 3/3: take the] ;
  92:  MESSAGE[load off. The robot] ;
  93:  MESSAGE[moves next.] ;
  94:  PAUSE ;
  95:  !to H0 ;
  96:J P[1] 25% FINE    ;
/POS
P[1]{
   GP1:
	UF : 0, UT : 1,	
	J1=    0.0000 deg,	J2=    0.0000 deg,	J3=    0.0000 deg,
	J4=    0.0000 deg,	J5=    0.0000 deg,	J6=    0.0000 deg,
	E1=    0.0000  mm
};
P[2]{
   GP1:
	UF : 0, UT : 1,	
	J1=    5.2296 deg,	J2=  -11.9592 deg,	J3=   16.6887 deg,
	J4=  -23.4183 deg,	J5=   28.1479 deg,	J6=  -34.8775 deg,
	E1= 1233.5679  mm
};
P[3]{
   GP1:
	UF : 0, UT : 1,	
	J1=    5.7296 deg,	J2=  -11.4592 deg,	J3=   17.1887 deg,
	J4=  -22.9183 deg,	J5=   28.6479 deg,	J6=  -34.3775 deg,
	E1= 1234.5679  mm
};
P[4]{
   GP1:
	UF : 0, UT : 1,	
	J1=   62.5254 deg,	J2=   68.2549 deg,	J3=  -74.9845 deg,
	J4=   79.7141 deg,	J5=  -86.4437 deg,	J6=  177.1169 deg,
	E1=  499.0000  mm
};
P[5]{
   GP1:
	UF : 0, UT : 1,	
	J1=   63.0254 deg,	J2=   68.7549 deg,	J3=  -74.4845 deg,
	J4=   80.2141 deg,	J5=  -85.9437 deg,	J6=  177.6169 deg,
	E1=  500.0000  mm
};
/END
